#include "common/base/result.h"

namespace tessera {

std::string Error::text() const {
  std::string line;
  if (!where.empty()) line += where + ": ";
  line += what;
  if (!mend.empty()) line += "; " + mend;
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

Error inputError(std::string where, std::string what, std::string mend) {
  return {ErrorKind::Input, std::move(where), std::move(what), std::move(mend)};
}

Error runtimeError(std::string where, std::string what, std::string mend) {
  return {ErrorKind::Runtime, std::move(where), std::move(what), std::move(mend)};
}

}  // namespace tessera
