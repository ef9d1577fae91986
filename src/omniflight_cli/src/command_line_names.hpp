// Names of the command line's parser for headers that only refer to it: its own header costs every source
// that includes it four seconds.
#pragma once

namespace CLI {
class App;
class Validator;
}  // namespace CLI
