#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include <sys/types.h>

namespace tessera::test {

struct Outcome {
  int status = -1;  ///< exit status; 128 + signal where one ended it; -1: it had to be killed at the deadline
  std::string out, err;
};

/// A program under test with its output in files. Killed, with its whole process group, when this goes away.
class Process {
 public:
  Process(const std::vector<std::string>& arguments,
          const std::map<std::string, std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  void signal(int number) const;
  /// Waits; kills it at the deadline.
  Outcome wait(std::chrono::milliseconds deadline);
  /// Standard output and error so far.
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;
  /// Waits until the output holds a text; false at the deadline or when the program ends without it.
  [[nodiscard]] bool waitForOut(const std::string& text, std::chrono::milliseconds deadline) const;
  [[nodiscard]] bool waitForErr(const std::string& text, std::chrono::milliseconds deadline) const;

 private:
  [[nodiscard]] bool ended() const;
  pid_t pid_ = -1;
  mutable int status_ = 0;
  mutable bool reaped_ = false;
  std::string outFile_, errFile_;
};

/// Runs a program to its end.
Outcome run(const std::vector<std::string>& arguments,
            std::chrono::milliseconds deadline = std::chrono::seconds(60),
            const std::map<std::string, std::string>& environment = {});

/// A folder that goes away with this.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Writes a file and returns its path.
  [[nodiscard]] std::string write(const std::string& name, const std::string& content) const;

 private:
  std::string path_;
};

/// The built program of that name.
std::string program(const std::string& name);
/// A real scene, or empty where the folder of scenes is not there.
std::string sharedScene(const std::string& name);
std::string config(const std::string& name);

}  // namespace tessera::test
