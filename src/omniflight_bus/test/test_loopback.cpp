// Where loopback is promised nothing listens on another interface, and no environment changes that silently.
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "bus_fixture.hpp"

namespace omniflight::bus {
namespace {

struct Socket {
  std::uint32_t address = 0;
  std::string device;
};

/// UDP sockets of this process that have a port.
std::vector<Socket> udp_sockets() {
  std::vector<Socket> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename().string());
    int type = 0;
    socklen_t size = sizeof type;
    if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) continue;
    sockaddr_in address{};
    size = sizeof address;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.sin_family != AF_INET)
      continue;
    char device[32] = {};
    size = sizeof device - 1;
    getsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, device, &size);
    out.push_back({ntohl(address.sin_addr.s_addr), device});
  }
  return out;
}

class Loopback : public BusTest {};

TEST_F(Loopback, EverySocketIsBoundToIt) {
  const Participant participant = join();
  const auto sockets = udp_sockets();
  ASSERT_FALSE(sockets.empty());
  for (const Socket& s : sockets)
    EXPECT_TRUE(s.device == "lo" || (s.address >> 24) == 127) << std::hex << s.address << " " << s.device;
}

TEST_F(Loopback, AnOutsideConfigurationIsNotTakenAndThatIsSaid) {
  setenv("CYCLONEDDS_URI", "file:///etc/another.xml", 1);
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(use_loopback(OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml"));
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("file:///etc/another.xml is not used"), std::string::npos) << said;
  EXPECT_NE(std::string(std::getenv("CYCLONEDDS_URI")).find("cyclonedds_loopback.xml"), std::string::npos);
  EXPECT_TRUE(loopback_promised());
}

TEST_F(Loopback, AnotherConfigurationIsChosenByName) {
  setenv("OMNIFLIGHT_BUS", "/nowhere.xml", 1);
  const auto missing = use_loopback(OMNIFLIGHT_SOURCE_ROOT "/configs/cyclonedds_loopback.xml");
  unsetenv("OMNIFLIGHT_BUS");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().text().find("OMNIFLIGHT_BUS=/nowhere.xml"), std::string::npos)
      << missing.error().text();
}

}  // namespace
}  // namespace omniflight::bus
