// What a process asks of the system so that a control loop in it is not delayed: a real-time priority, and
// memory that is in RAM before the loop begins.
#pragma once

namespace omniflight::components {

/// Lets every heap that malloc makes for a thread from now on begin with some megabytes, which
/// ask_for_real_time() brings into RAM. Before the middleware's threads exist.
void widen_thread_heaps();

/// Gives the calling thread a real-time priority and keeps the process's memory in RAM, where the system
/// allows it; says on stderr what it does not.
void ask_for_real_time(const char* name);

}  // namespace omniflight::components
