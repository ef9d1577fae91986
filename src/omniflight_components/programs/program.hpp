// What the programs of all components share; each is a main() with its name (programs/main.cpp).
#pragma once

namespace omniflight::components {

/// Reads the command line and runs the component until it is told to stop; `name` empty: those that the
/// command line names, in one process. Returns the exit code.
int run_program(const char* name, int argc, char** argv);

}  // namespace omniflight::components
