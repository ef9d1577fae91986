// Damaged RTPS packets: a participant, in clear text or secured, gets packets that were captured from live
// traffic and damaged, under the identities of peers that are alive. It stays alive, keeps its memory, and
// meets the next peer.
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include <cstring>
#include <map>
#include <random>
#include <set>

#include "secured_peers.hpp"

namespace omniflight::bus {
namespace {

constexpr double kMostGrowth_MB = 5.0;

/// 250000 for either in the long tests, see CMakeLists.txt.
int packets_to_send() {
  const char* told = std::getenv("OMNIFLIGHT_RUNS");
  return told ? std::max(1, std::atoi(told)) : 10'000;
}

struct Traffic {
  std::vector<std::string> packets;  ///< distinct
  std::set<std::uint16_t> ports;     ///< of their receivers
  std::set<std::string> kinds;       ///< sequences of submessage ids
};

/// The ids of the submessages of an RTPS packet.
std::string kind_of(const std::string& packet) {
  std::string out;
  for (std::size_t at = 20; at + 4 <= packet.size();) {
    out += packet[at];
    std::uint16_t length = 0;
    std::memcpy(&length, packet.data() + at + 2, 2);
    if (length == 0) break;  // to the end
    at += 4u + length;
  }
  return out;
}

/// RTPS packets of this domain on the loopback interface for so long. Nothing without the right to look
/// (root).
std::optional<Traffic> capture(int domain, std::chrono::milliseconds during) {
  const int raw = socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP));
  if (raw < 0) return {};
  sockaddr_ll device{};
  device.sll_family = AF_PACKET;
  device.sll_protocol = htons(ETH_P_IP);
  device.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
  if (bind(raw, reinterpret_cast<sockaddr*>(&device), sizeof device) != 0) {
    close(raw);
    return {};
  }
  Traffic out;
  std::set<std::string> seen;
  std::string buffer(65536, '\0');
  const int first = 7400 + 250 * domain;
  for (const auto end = std::chrono::steady_clock::now() + during; std::chrono::steady_clock::now() < end;) {
    pollfd input{raw, POLLIN, 0};
    if (poll(&input, 1, 50) <= 0) continue;
    const ssize_t n = recv(raw, buffer.data(), buffer.size(), 0);
    const auto* ip = reinterpret_cast<const iphdr*>(buffer.data());
    const std::size_t begin = ip->ihl * 4u;
    if (n < static_cast<ssize_t>(begin + sizeof(udphdr) + 20) || ip->protocol != IPPROTO_UDP) continue;
    udphdr udp;
    std::memcpy(&udp, buffer.data() + begin, sizeof udp);
    const int port = ntohs(udp.dest);
    std::string packet = buffer.substr(begin + sizeof udp, static_cast<std::size_t>(n) - begin - sizeof udp);
    if (port < first || port >= first + 250 || packet.compare(0, 4, "RTPS") != 0) continue;
    out.kinds.insert(kind_of(packet));
    if (out.packets.size() < 2000 && seen.insert(packet).second) out.packets.push_back(std::move(packet));
    out.ports.insert(static_cast<std::uint16_t>(port));
  }
  close(raw);
  return out;
}

double resident_MB(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/statm");
  double size = 0, resident = 0;
  in >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

void damage(std::string& packet, std::mt19937_64& random) {
  const auto at = [&] { return packet.empty() ? 0 : random() % packet.size(); };
  switch (random() % 6) {
    case 0:
      packet[at()] ^= static_cast<char>(1 << random() % 8);
      break;
    case 1:  // behind the header: submessages, lengths, parameters
      if (packet.size() > 24) packet[20 + random() % (packet.size() - 20)] = static_cast<char>(random());
      break;
    case 2:
      packet.resize(20 + random() % (packet.size() - 19));
      break;
    case 3:
      if (packet.size() > 28) {
        const std::uint16_t length = static_cast<std::uint16_t>(random());
        std::memcpy(packet.data() + 20 + random() % (packet.size() - 24), &length, 2);
      }
      break;
    case 4:
      for (std::size_t k = at(), end = std::min(packet.size(), k + 16); k < end; ++k)
        packet[k] = static_cast<char>(random());
      break;
    default:
      packet.append(random() % 200, static_cast<char>(random()));
  }
}

class MutatedPackets : public SecuredPeers, public ::testing::WithParamInterface<bool> {};

TEST_P(MutatedPackets, LeaveTheParticipantAlive) {
  const bool secured = GetParam();
  start_gateway(secured);
  const pid_t commander = start_commander(secured);
  const auto traffic = capture(claim->domain(), 1500ms);
  if (!traffic) {
    kill(commander, SIGKILL);
    waitpid(commander, nullptr, 0);
    GTEST_SKIP() << "capturing packets on the loopback interface needs root";
  }
  EXPECT_GT(heard(), 0);
  ASSERT_GT(traffic->packets.size(), 20u);
  const double before_MB = resident_MB(gateway_pid());
  const int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::mt19937_64 random(5);
  std::vector<sockaddr_in> to;
  for (const std::uint16_t port : traffic->ports) {
    to.emplace_back();
    to.back().sin_family = AF_INET;
    to.back().sin_port = htons(port);
    to.back().sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  const int count = packets_to_send();
  for (int k = 0; k < count; ++k) {
    std::string packet = traffic->packets[random() % traffic->packets.size()];
    for (std::uint64_t n = 1 + random() % 3; n > 0; --n) damage(packet, random);
    const sockaddr_in& address = to[random() % to.size()];
    sendto(out, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    if (k % 32 == 0) std::this_thread::sleep_for(1ms);  // so that they are read, not dropped
  }
  close(out);
  EXPECT_EQ(waitpid(gateway_pid(), nullptr, WNOHANG), 0)
      << "the gateway died: " << slurp(folder / "gateway.log");
  const double grown_MB = resident_MB(gateway_pid()) - before_MB;
  kill(commander, SIGKILL);
  waitpid(commander, nullptr, 0);
  (void)heard();
  patience = 10s;
  const Attempt next = attempt([&]() -> Status {
    (void)use_loopback_here();
    return secured ? use_security(keys, "commander") : Status();
  });
  EXPECT_EQ(next.said, "met") << next.log;
  EXPECT_GT(heard(), 0);
  EXPECT_LT(grown_MB, kMostGrowth_MB);
  std::printf("%d damaged packets of %zu captured ones, %zu kinds, %s: alive, memory grew by %.1f MB\n",
              count, traffic->packets.size(), traffic->kinds.size(), secured ? "secured" : "in clear text",
              grown_MB);
}

INSTANTIATE_TEST_SUITE_P(Bus, MutatedPackets, ::testing::Values(false, true),
                         [](const auto& secured) { return secured.param ? "Secured" : "InClearText"; });

}  // namespace
}  // namespace omniflight::bus
