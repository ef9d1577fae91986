// Errors of the libraries as the one Python exception, omniflight.Error.
#pragma once

#include <pybind11/pybind11.h>

#include "omniflight_core/result.hpp"

namespace omniflight::python {

/// Raises omniflight.Error. The interpreter's lock must be held.
[[noreturn]] void raise(const Error& error);

/// The value, or the exception.
template <class T>
T take(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}
inline void take(const Status& status) {
  if (!status) raise(status.error());
}

/// Runs `work` without the interpreter's lock, so that other Python threads go on.
template <class Work>
auto unlocked(const Work& work) {
  pybind11::gil_scoped_release release;
  return work();
}

/// For long work to ask from any thread: true once the user pressed Ctrl-C. Cheap: looks ten times a second.
/// After the work, raise_interrupt() makes KeyboardInterrupt of it. Both want the lock as they find it:
/// wanted() without, raise_interrupt() with it.
bool interrupt_wanted();
void begin_interruptible();
void raise_interrupt();

}  // namespace omniflight::python
