#include "common/base/system_call_filter.h"

#include <cerrno>
#include <cstddef>
#include <cstdint>

#include <linux/audit.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace tessera {

namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;
#endif

constexpr std::uint32_t kRefuse = SECCOMP_RET_ERRNO | EPERM;
constexpr std::uint32_t kUnknown = SECCOMP_RET_ERRNO | ENOSYS;
constexpr std::uint32_t kX32Bit = 0x40000000;
constexpr long kFchmodat2 = 452;  // newer than Debian 12's headers; the same number everywhere

/// System calls that are refused whatever their arguments are.
constexpr long kRefused[] = {
    // The network, and local sockets. io_uring would be a way around this filter.
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendto,
    SYS_sendmsg,
    SYS_sendmmsg,
    SYS_io_uring_setup,
    SYS_io_uring_enter,
    SYS_io_uring_register,
    // Other programs and other processes.
    SYS_execve,
    SYS_execveat,
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_kcmp,
    SYS_pidfd_open,
    SYS_pidfd_getfd,
    SYS_pidfd_send_signal,
    SYS_rt_sigqueueinfo,
    SYS_rt_tgsigqueueinfo,
    SYS_process_madvise,
    SYS_setpriority,
    SYS_sched_setscheduler,
    SYS_sched_setattr,
    // Rights, owners and attributes of files, which Landlock does not hold.
    SYS_fchmod,
    SYS_fchmodat,
    kFchmodat2,
    SYS_fchown,
    SYS_fchownat,
    SYS_setxattr,
    SYS_lsetxattr,
    SYS_fsetxattr,
    SYS_removexattr,
    SYS_lremovexattr,
    SYS_fremovexattr,
    SYS_open_by_handle_at,
    SYS_name_to_handle_at,
    // The machine.
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_setns,
    SYS_unshare,
    SYS_open_tree,
    SYS_move_mount,
    SYS_fsopen,
    SYS_fsconfig,
    SYS_fsmount,
    SYS_fspick,
    SYS_mount_setattr,
    SYS_bpf,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_keyctl,
    SYS_add_key,
    SYS_request_key,
    SYS_init_module,
    SYS_finit_module,
    SYS_delete_module,
    SYS_kexec_load,
    SYS_reboot,
    SYS_swapon,
    SYS_swapoff,
    SYS_settimeofday,
    SYS_clock_settime,
    SYS_clock_adjtime,
    SYS_adjtimex,
    SYS_acct,
    SYS_quotactl,
    SYS_sethostname,
    SYS_setdomainname,
    SYS_personality,
    SYS_fanotify_init,
    SYS_syslog,
    SYS_vhangup,
    SYS_nfsservctl,
#if defined(__x86_64__)
    SYS_fork,
    SYS_vfork,
    SYS_chmod,
    SYS_chown,
    SYS_lchown,
    SYS_utime,
    SYS_utimes,
    SYS_futimesat,
    SYS_iopl,
    SYS_ioperm,
    SYS_modify_ldt,
    SYS_kexec_file_load,
    SYS_create_module,
    SYS_uselib,
    SYS_ustat,
#endif
};

sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
/// The lower half of an argument, little-endian.
sock_filter loadArgument(unsigned index) {
  return load(offsetof(seccomp_data, args) + index * sizeof(std::uint64_t));
}
sock_filter loadUpperHalf(unsigned index) {
  return load(offsetof(seccomp_data, args) + index * sizeof(std::uint64_t) + sizeof(std::uint32_t));
}
sock_filter answer(std::uint32_t value) {
  return BPF_STMT(BPF_RET | BPF_K, value);
}
sock_filter jump(unsigned condition, std::uint32_t value, unsigned ifTrue, unsigned ifFalse) {
  return BPF_JUMP(static_cast<std::uint16_t>(BPF_JMP | condition | BPF_K), value,
                  static_cast<std::uint8_t>(ifTrue), static_cast<std::uint8_t>(ifFalse));
}

class FilterBuilder {
 public:
  FilterBuilder() {
    // Numbers of another architecture's calls would be mistaken.
    add({load(offsetof(seccomp_data, arch)), jump(BPF_JEQ, kArchitecture, 1, 0), answer(kRefuse)});
    loadNumber();
#if defined(__x86_64__)
    add({jump(BPF_JGE, kX32Bit, 0, 1), answer(kRefuse)});
#endif
  }
  void refuse(long call, std::uint32_t with = kRefuse) {
    add({jump(BPF_JEQ, static_cast<std::uint32_t>(call), 0, 1), answer(with)});
  }
  /// What `body` answers, or the filter's end, decides about one call.
  void judge(long call, const std::vector<sock_filter>& body) {
    add({jump(BPF_JEQ, static_cast<std::uint32_t>(call), 0, static_cast<unsigned>(body.size()) + 1)});
    add(body);
    add({answer(SECCOMP_RET_ALLOW)});
  }
  std::vector<sock_filter> finish() {
    add({answer(SECCOMP_RET_ALLOW)});
    return std::move(program_);
  }

 private:
  void loadNumber() {
    add({load(offsetof(seccomp_data, nr))});
  }
  void add(const std::vector<sock_filter>& part) {
    program_.insert(program_.end(), part.begin(), part.end());
  }
  std::vector<sock_filter> program_;
};

}  // namespace

std::vector<sock_filter> systemCallFilter() {
  if (kArchitecture == 0) return {};
  FilterBuilder filter;
  for (const long call : kRefused)
    filter.refuse(call);
  // Threads may be started, processes not. The flags of clone3 cannot be seen from here, and the C library
  // falls back to clone where there is no clone3.
  filter.refuse(SYS_clone3, kUnknown);
  filter.judge(SYS_clone, {loadArgument(0), jump(BPF_JSET, CLONE_THREAD, 1, 0), answer(kRefuse)});
  // Signals to itself only: abort() needs them.
  const auto self = static_cast<std::uint32_t>(::getpid());
  for (const long call : {SYS_kill, SYS_tgkill}) {
    filter.judge(call, {loadArgument(0), jump(BPF_JEQ, self, 1, 0), answer(kRefuse)});
  }
  filter.refuse(SYS_tkill);
  // Times of files that are open, not of files by name.
  filter.judge(SYS_utimensat, {loadArgument(1), jump(BPF_JEQ, 0, 0, 2), loadUpperHalf(1),
                               jump(BPF_JEQ, 0, 1, 0), answer(kRefuse)});
  // Limits of this process, not of others (0 is this one).
  filter.judge(SYS_prlimit64,
               {loadArgument(0), jump(BPF_JEQ, 0, 2, 0), jump(BPF_JEQ, self, 1, 0), answer(kRefuse)});
  // Typing into the terminal that started it.
  filter.judge(SYS_ioctl, {loadArgument(1), jump(BPF_JEQ, TIOCSTI, 1, 0), jump(BPF_JEQ, TIOCLINUX, 0, 1),
                           answer(kRefuse)});
  return filter.finish();
}

}  // namespace tessera
