// Bytes of unknown origin on the boards' line: frames, and what they carry, both ways.
#include "mutated_inputs.hpp"
#include "omniflight_gateway/tk3_codec.hpp"
#include "omniflight_gateway/tk3_frame.hpp"

using namespace omniflight::gateway;

std::vector<std::string> seeds() {
  std::string line;
  for (const char* text :
       {"v\x01\x02\x03", "?", "b\x01\x0c\x34", "m\x01\x02\x03\x04\x05\x06\x07", "i\x01\x02"}) {
    Body body;
    for (const char* c = text; *c != 0; ++c) (void)body.push(static_cast<std::uint8_t>(*c));
    const Wire wire = encode_frame(body);
    for (const std::uint8_t byte : wire.view()) line.push_back(static_cast<char>(byte));
  }
  return {line, "^\\!$^^$!"};
}

void feed(std::string_view input) {
  FrameDecoder decoder;
  for (const char c : input) {
    if (!decoder.push(static_cast<std::uint8_t>(c))) continue;
    (void)decode_host(decoder.body());
    (void)decode_board(decoder.body());
  }
}
