// Errors as values. User, data and hardware errors travel as Result; asserts are for our own bugs.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace omniflight {

/// Why something could not be done. The values are the exit codes of the command line.
enum class ErrorCode {
  internal = 1,    ///< a bug of ours
  incomplete = 2,  ///< the work ended without the wanted result (no path, not flown to the end)
  impossible = 3,  ///< proven impossible
  bad_input = 4,   ///< a file, option or message that cannot be used as it is
};

/// One sentence that names what is wrong, where (file, line, field) and what to do next.
struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;    ///< what is wrong, with value and unit
  std::string where;      ///< file:line or field, empty when there is none
  std::string next_step;  ///< what the reader can do about it

  /// "where: message. next step" on one line.
  std::string text() const {
    std::string out = where.empty() ? message : where + ": " + message;
    if (!next_step.empty()) out += ". " + next_step;
    return out;
  }
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

using Failure = tl::unexpected<Error>;

/// Shorthand for returning an error from a function that returns a Result.
inline Failure fail(ErrorCode code, std::string message, std::string where = {}, std::string next_step = {}) {
  return Failure(Error{code, std::move(message), std::move(where), std::move(next_step)});
}
inline Failure bad_input(std::string message, std::string where = {}, std::string next_step = {}) {
  return fail(ErrorCode::bad_input, std::move(message), std::move(where), std::move(next_step));
}

}  // namespace omniflight
