#include "omniflight_bus/message.hpp"

#include <cstring>

#include "dds/dds.h"

namespace omniflight::bus {
namespace detail {

void free_contents(const msgs::MessageType& type, void* sample) {
  dds_sample_free(sample, type.descriptor, DDS_FREE_CONTENTS);
}

void* reallocate_zeroed(void* buffer, std::size_t old_bytes, std::size_t new_bytes) {
  void* out = dds_realloc(buffer, new_bytes);
  std::memset(static_cast<char*>(out) + old_bytes, 0, new_bytes - old_bytes);
  return out;
}

}  // namespace detail

void set_text(char*& field, std::string_view value) {
  if (field == nullptr || std::strlen(field) < value.size()) {
    field = static_cast<char*>(dds_realloc(field, value.size() + 1));
  }
  std::memcpy(field, value.data(), value.size());
  field[value.size()] = '\0';
}

}  // namespace omniflight::bus
