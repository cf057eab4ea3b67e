#pragma once

#include <cstdlib>
#include <string>
#include <utility>
#include <variant>

namespace tessera {

/// Whose fault an error is; decides the exit status of a program.
enum class ErrorKind {
  Input,    ///< the command line or an input file is wrong (exit status 2)
  Runtime,  ///< the program ran and failed (exit status 1)
};

/// One error, told so that a user can act on it: where it is, what is wrong, what would mend it.
struct Error {
  ErrorKind kind = ErrorKind::Runtime;
  std::string where;  ///< "FILE:LINE", "FILE", a flag, an address; may be empty
  std::string what;   ///< one sentence without a final stop
  std::string mend;   ///< may be empty

  /// "WHERE: what; mend" on one line; control characters are replaced, so that hostile input cannot
  /// forge further lines.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] int exitStatus() const { return kind == ErrorKind::Input ? 2 : 1; }
};

[[nodiscard]] Error inputError(std::string where, std::string what, std::string mend = {});
[[nodiscard]] Error runtimeError(std::string where, std::string what, std::string mend = {});

/// A value or the Error that kept it from being made. Libraries return it and never print or exit.
/// Reading the value of a failed Result is a programming error and aborts.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit by design
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit by design

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] T& value() & { return checked(); }
  [[nodiscard]] const T& value() const& { return const_cast<Result*>(this)->checked(); }
  [[nodiscard]] T&& value() && { return std::move(checked()); }
  T& operator*() & { return checked(); }
  const T& operator*() const& { return const_cast<Result*>(this)->checked(); }
  T&& operator*() && { return std::move(checked()); }
  T* operator->() { return &checked(); }
  const T* operator->() const { return &const_cast<Result*>(this)->checked(); }

  [[nodiscard]] const Error& error() const {
    if (ok()) std::abort();
    return *std::get_if<1>(&state_);
  }

 private:
  T& checked() {
    if (!ok()) std::abort();
    return *std::get_if<0>(&state_);
  }
  std::variant<T, Error> state_;
};

/// Success without a value.
struct Done {};
using Status = Result<Done>;

}  // namespace tessera
