// Gateway and emulated boards over real pseudo terminals: the bad days.
#include "pty_flight.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <omniflight_core/random.hpp>

namespace omniflight::gateway {
namespace {

/// A directory for device links that goes away with the test.
struct LinkDirectory {
  LinkDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "omniflight_boards_XXXXXX").string();
    path = mkdtemp(pattern.data());
  }
  ~LinkDirectory() { std::filesystem::remove_all(path); }
  std::string path;
};
EmulatorConfig linked(const LinkDirectory& directory) {
  EmulatorConfig c = EmulatorConfig::omnimorph();
  c.link_directory = directory.path;
  return c;
}

TEST(GatewayFaults, AnUnpluggedBoardIsNoticedAndTheOthersStayInHand) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  ASSERT_TRUE(f.hold(std::vector<double>(8, 600), 0.1));
  const double cut_s = f.now_s;
  f.emulator.unplug(0);
  const Status status = f.hold(std::vector<double>(8, 600), 1.0);
  ASSERT_FALSE(status);
  EXPECT_LT(f.now_s - cut_s, 0.5);
  EXPECT_EQ(f.gateway.phase(), GatewayPhase::failed);
  EXPECT_NE(status.error().text().find("/dev/pts/"), std::string::npos);
  EXPECT_NE(status.error().next_step.find("connect again"), std::string::npos);
  // The safety gate can still wind down the second board; the lost one ramps down on its own watchdog.
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(f.gateway.send_velocities(std::vector<double>(8, 300)));
    EXPECT_FALSE(f.tick());
  }
  EXPECT_NEAR(f.emulator.command()[5], 300, 0.1);
  EXPECT_NEAR(f.emulator.command()[1], 600, 0.5);
  while (f.now_s < cut_s + 1.1) (void)f.tick();
  EXPECT_EQ(f.emulator.command()[1], 0.0);
}

TEST(GatewayFaults, ReopensFiftyTimesOutOfFifty) {
  LinkDirectory directory;
  PtyFlight f(linked(directory));
  Random random(6, "unplug");
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(f.connect(false)) << "round " << i;
    ASSERT_TRUE(f.until([] { return false; }, 0.005));
    const std::size_t victim = random.next() % 3;
    f.emulator.unplug(victim);
    ASSERT_FALSE(f.until([] { return false; }, 0.5)) << "round " << i;
    ASSERT_FALSE(f.gateway.connect(f.now_s));  // still unplugged: a clear error, no hang
    EXPECT_NE(f.gateway.error()->text().find("board" + std::to_string(victim)), std::string::npos);
    ASSERT_TRUE(f.emulator.plug(victim));
  }
  EXPECT_TRUE(f.connect());
}

TEST(GatewayFaults, ASilentBoardIsLostWithinItsDeadline) {
  PtyFlight f;
  ASSERT_TRUE(f.connect());
  ASSERT_TRUE(f.until([] { return false; }, 0.05));
  // The line stays up, nobody steps the boards any more.
  const double silent_s = f.now_s;
  Status status;
  while (status && f.now_s < silent_s + 2) {
    f.now_s += 1e-3;
    status = f.gateway.poll(f.now_s);
  }
  ASSERT_FALSE(status);
  EXPECT_LT(f.now_s - silent_s, 0.5);
  EXPECT_NE(status.error().message.find("silent"), std::string::npos);
}

TEST(GatewayFaults, NobodyAnsweringIsAnErrorAfterAllRetries) {
  auto pty = open_pseudo_terminal();
  ASSERT_TRUE(pty);
  BoardLink link(LinkConfig{.device = pty->path});
  ASSERT_TRUE(link.open(0.0));
  std::vector<BoardMessage> received;
  Status status;
  double now_s = 0.0;
  ByteStream board;
  std::vector<std::uint8_t> queries;
  while (status && now_s < 10) {
    status = link.poll(now_s += 0.01, received);
    wait_readable(std::array{pty->master.get()}, 1e-4);
    ASSERT_TRUE(board.read(pty->master.get(), queries));
  }
  ASSERT_FALSE(status);
  EXPECT_NEAR(now_s, 2.0, 0.05);  // 4 queries, 0.5 s each
  EXPECT_NE(status.error().message.find("4 id queries"), std::string::npos);
  EXPECT_EQ(std::string(queries.begin(), queries.end()), "^?$^?$^?$^?$");
}

TEST(GatewayFaults, GarbageOnTheLineIsCountedAndDoesNoHarm) {
  PtyFlight f;
  ASSERT_TRUE(f.connect() && f.start());
  ASSERT_TRUE(f.hold(std::vector<double>(8, 600), 0.05));
  // A second opener of the same line writes noise to the board, and the board's side writes noise to the
  // host.
  const int to_board = ::open(f.emulator.device(0).c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  ASSERT_GE(to_board, 0);
  Random random(7, "garbage");
  const auto refused_before = f.gateway.statistics().refused_frames;
  f.seen.clear();
  for (int i = 0; i < 300; ++i) {
    std::array<std::uint8_t, 64> noise;
    // Noise that could by chance say "stop motor" would test luck, so it keeps clear of that letter.
    for (auto& c : noise) do
        c = static_cast<std::uint8_t>(random.next() >> 56);
      while (c == 'x');
    ASSERT_GT(::write(to_board, noise.data(), noise.size()), 0);
    ASSERT_TRUE(f.emulator.inject_noise(1, noise));
    ASSERT_TRUE(f.hold(std::vector<double>(8, 600), 0.001));
  }
  ::close(to_board);
  ASSERT_TRUE(f.hold(std::vector<double>(8, 550), 0.1));
  EXPECT_GT(f.gateway.statistics().refused_frames, refused_before);
  EXPECT_GT(f.emulator.board(0).decoder_statistics().refused(), 5u);
  EXPECT_EQ(f.gateway.phase(), GatewayPhase::running);
  for (const double w : f.emulator.command()) EXPECT_NEAR(w, 550, 0.5);
  for (const auto& s : f.seen.rotors) EXPECT_LE(std::abs(s.speed_radps), 3000.0);
}

TEST(GatewayFaults, ImplausibleValuesInIntactFramesAreRefused) {
  PtyFlight f;
  ASSERT_TRUE(f.connect());
  ASSERT_TRUE(f.until([] { return false; }, 0.05));
  const auto inject = [&](std::size_t board, const BoardMessage& m) {
    const Wire wire = to_wire(m);
    ASSERT_TRUE(f.emulator.inject_noise(board, wire.view()));
    ASSERT_TRUE(f.until([] { return false; }, 0.01));
  };
  f.seen.clear();
  inject(0, MotorData{200, 9, false, true, false, 4000, 0, 0});  // no motor 9 there
  inject(0, MotorData{200, 1, false, true, false, 10, 0, 0});    // 50 kHz
  inject(0, ImuData{200, {1, 2, 3}, {}});                        // a Teensy has no IMU
  inject(2, ImuData{200, {0, 0, -32768}, {}});                   // from +9.81 to -78 within a millisecond
  EXPECT_EQ(f.gateway.statistics().implausible, 4u);
  for (const auto& s : f.seen.imu) EXPECT_GT(s.specific_force_B.z(), 9.0);
  for (const auto& s : f.seen.rotors) EXPECT_EQ(s.speed_radps, 0.0);
  inject(1, MotorData{200, 1, true, false, false, 0, 0, 0});  // one corrupted frame is no emergency
  EXPECT_FALSE(f.gateway.emergency());
}

TEST(GatewayFaults, MotorsThatDoNotStartAreNamed) {
  EmulatorConfig boards = EmulatorConfig::omnimorph();
  boards.boards[1].start_time_s = 100;
  PtyFlight f(boards);
  ASSERT_TRUE(f.connect());
  ASSERT_TRUE(f.gateway.start_motors(f.now_s));
  const Status status = f.until([] { return false; }, 5.5);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("rotors 5 6 7 8"), std::string::npos) << status.error().text();
}

TEST(GatewayFaults, WrongBoardsAreAClearError) {
  const auto connect_error = [](EmulatorConfig boards) {
    PtyFlight f(std::move(boards));
    if (!f.gateway.connect(f.now_s)) return std::string("cannot open");
    const Status status = f.until([&] { return f.gateway.connected(); }, 3.0);
    return status ? std::string() : status.error().text();
  };
  EmulatorConfig old = EmulatorConfig::omnimorph();
  old.boards[0].id = "teensy1.0";
  EXPECT_NE(connect_error(old).find("older than 1.1"), std::string::npos);
  EmulatorConfig foreign = EmulatorConfig::omnimorph();
  foreign.boards[2].id = "arduino7\x1b[2J";
  EXPECT_NE(connect_error(foreign).find("unknown board 'arduino7?[2J'"), std::string::npos);
  EmulatorConfig one = EmulatorConfig::omnimorph();
  one.boards.erase(one.boards.begin() + 1);
  EXPECT_NE(connect_error(one).find("no board drives rotor 4"), std::string::npos);
  EmulatorConfig blind = EmulatorConfig::omnimorph();
  blind.boards.pop_back();
  EXPECT_NE(connect_error(blind).find("no board has an IMU"), std::string::npos);
}

TEST(GatewayFaults, DevicesThatAreNoSerialLinesAreRefused) {
  const auto open_error = [](const std::string& device, unsigned baud) {
    const auto fd = open_serial(device, baud);
    return fd ? std::string() : fd.error().text();
  };
  EXPECT_NE(open_error("/nowhere/tty", 115200).find("/nowhere/tty: cannot open"), std::string::npos);
  EXPECT_NE(open_error("/dev/null", 115200).find("not a serial device"), std::string::npos);
  EXPECT_NE(open_error("/dev/null", 9600).find("baud rate 9600"), std::string::npos);
  auto pty = open_pseudo_terminal();
  ASSERT_TRUE(pty);
  for (const unsigned baud : {0u, 57600u, 115200u, 500000u, 2000000u})
    EXPECT_EQ(open_error(pty->path, baud), "");
}

TEST(GatewayFaults, ALineThatTakesNothingIsNoticed) {
  auto pty = open_pseudo_terminal();
  ASSERT_TRUE(pty);
  BoardLink link(LinkConfig{.device = pty->path});
  ASSERT_TRUE(link.open(0.0));
  const Wire reply = to_wire(BoardMessage(IdReply{"teensy1.2"}));
  ASSERT_GT(::write(pty->master.get(), reply.data.data(), reply.size), 0);
  std::vector<BoardMessage> received;
  VelocityCommand command;
  command.half_period_us.size = 31;
  command.half_period_us.values.fill(0x2424);
  Status status;
  double now_s = 0.0;
  while (status && now_s < 20) {  // nobody reads at the other end
    ASSERT_TRUE(link.send(command));
    status = link.poll(now_s += 1e-3, received);
  }
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("took no byte"), std::string::npos) << status.error().text();
  EXPECT_GT(link.superseded_commands(), 100u);  // old commands were replaced, not queued up
  EXPECT_FALSE(link.is_open());
}

TEST(GatewayFaults, BadConfigurationsAreRefused) {
  const auto error = [](auto change) {
    GatewayConfig c;
    c.boards = {{"/dev/a"}, {"/dev/b"}};
    change(c);
    const auto g = Gateway::create(c);
    return g ? std::string() : g.error().text();
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_NE(error([](auto& c) { c.boards.clear(); }).find("boards"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.boards[1].device = "/dev/a"; }).find("/dev/a"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.rotors = 0; }).find("rotors"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.imu_rate_hz = 2001; }).find("imu_rate_hz"), std::string::npos);
  EXPECT_NE(error([](auto& c) { c.motor_rate_hz = std::nan(""); }).find("motor_rate_hz"), std::string::npos);
  IdealPlant plant;
  EmulatorConfig overlap = EmulatorConfig::omnimorph();
  overlap.boards[1].rotor_offset = 3;
  EXPECT_FALSE(BoardEmulator::create(overlap, plant));
  EmulatorConfig nowhere = EmulatorConfig::omnimorph();
  nowhere.link_directory = "/nowhere/at/all";
  EXPECT_FALSE(BoardEmulator::create(nowhere, plant));
}

}  // namespace
}  // namespace omniflight::gateway
