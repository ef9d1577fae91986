// Lines on a machine so busy that the kernel's workers get no processor: a tty then delivers late, but nobody
// may stand still for it, and a socket delivers as ever.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "omniflight_gateway/local_socket.hpp"
#include "pty_flight.hpp"
#include "starved_kernel.hpp"

namespace omniflight::gateway {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct Folder {
  std::string path = [] {
    std::string name = (std::filesystem::temp_directory_path() / "omniflight_lines_XXXXXX").string();
    return std::string(::mkdtemp(name.data()));
  }();
  ~Folder() { std::filesystem::remove_all(path); }
};

EmulatorConfig behind_sockets(const Folder& folder) {
  auto c = EmulatorConfig::omnimorph();
  c.link_directory = folder.path;
  c.line = LineKind::socket;
  return c;
}

// The control thread is the one that stops the rotors when commands go stale.
TEST(BusyMachine, ReadingATtyWaitsForNobody) {
  auto pty = open_pseudo_terminal();
  ASSERT_TRUE(pty);
  auto host = open_serial(pty->path, 0);
  ASSERT_TRUE(host);
  ByteStream from_board, to_board;
  std::vector<std::uint8_t> in;
  double longest = 0;
  {
    const StarvedKernel starved(std::chrono::milliseconds(1200));
    if (!starved) GTEST_SKIP() << "needs the right to real-time priorities";
    const auto begin = Clock::now();
    while (seconds_since(begin) < 0.6) {
      ASSERT_TRUE(to_board.queue(std::array<std::uint8_t, 3>{'a', 'b', 'c'}));
      ASSERT_TRUE(to_board.flush(pty->master.get()));
      const auto before = Clock::now();
      ASSERT_TRUE(from_board.read(host->get(), in));
      longest = std::max(longest, seconds_since(before));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  EXPECT_LT(longest, 0.05);
  const auto begin = Clock::now();
  while (in.size() < to_board.bytes_written() && seconds_since(begin) < 5)
    ASSERT_TRUE(from_board.read(host->get(), in));
  EXPECT_EQ(in.size(), to_board.bytes_written()) << "what was late is not lost";
}

TEST(BusyMachine, BoardsBehindSocketsAreHeardAndCommanded) {
  const Folder folder;
  PtyFlight f(behind_sockets(folder));
  ASSERT_TRUE(f.connect(false));
  ASSERT_TRUE(f.start());
  const std::size_t samples = f.seen.imu.size();
  {
    const StarvedKernel starved(std::chrono::milliseconds(500));
    if (!starved) GTEST_SKIP() << "needs the right to real-time priorities";
    const auto begin = Clock::now();
    while (seconds_since(begin) < 0.2) {
      ASSERT_TRUE(f.gateway.send_velocities(std::vector<double>(8, 400.0)));
      const Status ok = f.tick();
      ASSERT_TRUE(ok) << ok.error().text();
    }
    EXPECT_GT(f.seen.imu.size(), samples + 100);
    EXPECT_NEAR(f.emulator.command()[7], 400.0, 1.0);
  }
}

TEST(BoardsBehindSockets, StayPoweredWhileHostsComeAndGo) {
  const Folder folder;
  PtyFlight f(behind_sockets(folder));
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(f.connect(false)) << k;
    f.gateway.close();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(f.emulator.step(f.now_s += 1e-3));
  }
  ASSERT_TRUE(f.connect(false));
  ASSERT_TRUE(f.start());
}

TEST(BoardsBehindSockets, ThatAreUnpluggedHangUp) {
  const Folder folder;
  PtyFlight f(behind_sockets(folder));
  ASSERT_TRUE(f.connect(false));
  ASSERT_TRUE(f.start());
  f.emulator.unplug(1);
  EXPECT_FALSE(is_local_socket(f.emulator.device(1)));
  Status status;
  for (int i = 0; i < 100 && status; ++i) {
    (void)f.gateway.send_velocities(std::vector<double>(8, 400.0));  // into a line without an end: no SIGPIPE
    status = f.tick();
  }
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("board1"), std::string::npos) << status.error().text();
  ASSERT_TRUE(f.emulator.plug(1));
  ASSERT_TRUE(f.connect(false));
}

// A host that stops reading must not make the emulator wait, nor may commands pile up towards a board that
// does not read.
TEST(BoardsBehindSockets, NobodyWaitsForAnEndThatDoesNotRead) {
  const Folder folder;
  PtyFlight f(behind_sockets(folder));
  ASSERT_TRUE(f.connect(false));
  ASSERT_TRUE(f.until([&] { return !f.seen.imu.empty(); }, 1));
  const auto begin = Clock::now();
  for (int i = 0; i < 20000; ++i) ASSERT_TRUE(f.emulator.step(f.now_s += 1e-3));
  EXPECT_LT(seconds_since(begin), 5);
  EXPECT_GT(f.emulator.dropped_frames(), 100u);

  auto listener = listen_local(folder.path + "/deaf");
  ASSERT_TRUE(listener);
  auto host = open_serial(folder.path + "/deaf", 115200);
  ASSERT_TRUE(host);
  ByteStream line(1 << 20);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(line.queue(std::array<std::uint8_t, 18>{}));
    ASSERT_TRUE(line.flush(host->get()));
  }
  EXPECT_LT(line.bytes_written(), 30u * 18u);
}

TEST(BoardsBehindSockets, NameWhatIsWrong) {
  const auto error = [](EmulatorConfig config) {
    IdealPlant plant;
    const auto made = BoardEmulator::create(std::move(config), plant);
    return made ? std::string() : made.error().text();
  };
  Folder folder;
  auto config = behind_sockets(folder);
  config.link_directory.clear();
  EXPECT_NE(error(config).find("link_directory"), std::string::npos);
  config.link_directory = folder.path + "/missing";
  EXPECT_NE(error(config).find("/missing/board0"), std::string::npos);
  // longer than a socket's address, and left behind by a killed run
  config.link_directory = folder.path + "/" + std::string(200, 'x');
  std::filesystem::create_directory(config.link_directory);
  std::filesystem::create_symlink("/dev/pts/0", config.link_directory + "/board0");
  ASSERT_TRUE(listen_local(config.link_directory + "/board1"));
  EXPECT_EQ(error(config), "");
  ASSERT_TRUE(listen_local(folder.path + "/dead"));
  const auto nobody = open_serial(folder.path + "/dead", 115200);
  ASSERT_FALSE(nobody);
  EXPECT_NE(nobody.error().text().find("Check that the emulator runs"), std::string::npos);
}

}  // namespace
}  // namespace omniflight::gateway
