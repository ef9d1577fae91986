// Each test works in a domain of its own, on the loopback interface.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <thread>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/participant.hpp"

namespace omniflight::bus {

using namespace std::chrono_literals;

class BusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(use_loopback(OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml"));
    Result<DomainClaim> claimed = claim_free_domain(1, 100);
    ASSERT_TRUE(claimed) << claimed.error().text();
    claim.emplace(std::move(*claimed));
  }
  Participant join() {
    Result<Participant> participant = Participant::create(claim->domain());
    if (!participant) throw std::runtime_error(participant.error().text());
    return *participant;
  }
  /// Waits until the condition holds; false after the timeout.
  template <class Condition>
  static bool eventually(Condition condition, std::chrono::milliseconds timeout = 5s) {
    for (const auto end = std::chrono::steady_clock::now() + timeout; !condition();) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  std::optional<DomainClaim> claim;
};

}  // namespace omniflight::bus
