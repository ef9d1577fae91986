// One program for every component (omniflight_simulator, omniflight_controller, ...) and for the container
// that runs several of them in one process.
#include "program.hpp"

int main(int argc, char** argv) {
  return omniflight::components::run_program(OMNIFLIGHT_COMPONENT, argc, argv);
}
