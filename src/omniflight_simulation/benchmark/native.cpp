// The batch once more, with its kernel tuned for this very processor. peers.cmake compiles the sources of the
// batch under other names (-DBatch=NativeBatch, ...), so that both live in one program and take turns.
#include "batch_contender.hpp"

namespace omniflight::benchmarks {

Contender native_batch(const vehicle::Vehicle& vehicle, const std::string& name, const physics::Model& model,
                       int count) {
  return batch_contender<simulation::Batch, simulation::BatchConfig>(vehicle, name, model, count);
}

}  // namespace omniflight::benchmarks
