#include "omniflight_gateway/board_emulator.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <set>

#include "omniflight_gateway/local_socket.hpp"

namespace omniflight::gateway {
namespace {

std::uint64_t frames_in(const std::vector<std::uint8_t>& wire) {
  return static_cast<std::uint64_t>(std::count(wire.begin(), wire.end(), std::uint8_t{'$'}));
}

}  // namespace

EmulatorConfig EmulatorConfig::omnimorph() {
  EmulatedBoardConfig first;
  first.has_battery = false;
  EmulatedBoardConfig second = first;
  second.rotor_offset = 4;
  EmulatedBoardConfig chimera;
  chimera.id = "chimera1.1";
  chimera.rotors = 0;
  chimera.has_imu = true;
  chimera.imu_scale = chimera_imu_scale();
  return {{first, second, chimera}, {}, LineKind::pseudo_terminal, {}};
}

BoardEmulator::BoardEmulator(EmulatorConfig config, EmulatedPlant& plant)
    : link_directory_(std::move(config.link_directory)),
      line_(config.line),
      on_received_(std::move(config.on_received)),
      plant_(&plant) {
  for (auto& board : config.boards)
    boards_.push_back({EmulatedBoard(std::move(board)), {}, {}, {}, ByteStream(16384)});
}

Result<BoardEmulator> BoardEmulator::create(EmulatorConfig config, EmulatedPlant& plant) {
  if (config.line == LineKind::socket && config.link_directory.empty())
    return bad_input("sockets need a directory to lie in", "link_directory",
                     "Give an existing, writable link_directory");
  std::set<std::size_t> ids;
  std::size_t total = 0;
  for (std::size_t i = 0; i < config.boards.size(); ++i) {
    const auto& board = config.boards[i];
    const std::string where = "boards[" + std::to_string(i) + "]";
    if (board.rotors > 15)
      return bad_input("a board drives at most 15 rotors", where + ".rotors", "Use more boards");
    for (std::size_t k = 0; k < board.rotors; ++k) ids.insert(board.rotor_offset + k);
    total += board.rotors;
    if (ids.size() != total || (total > 0 && *ids.rbegin() > 63)) {
      return bad_input("rotor ids overlap or exceed 63", where + ".rotor_offset",
                       "Give every board its own ids");
    }
  }
  const std::size_t rotors = ids.empty() ? 0 : *ids.rbegin() + 1;
  BoardEmulator emulator(std::move(config), plant);
  emulator.command_.assign(rotors, 0.0);
  for (std::size_t i = 0; i < emulator.boards_.size(); ++i) {
    if (auto ok = emulator.plug(i); !ok) return Failure(ok.error());
  }
  return emulator;
}

BoardEmulator::~BoardEmulator() {
  for (std::size_t i = 0; i < boards_.size(); ++i) unplug(i);
}

std::string BoardEmulator::link(std::size_t i) const {
  return link_directory_ + "/board" + std::to_string(i);
}

std::string BoardEmulator::device(std::size_t i) const {
  return link_directory_.empty() ? boards_[i].pty.path : link(i);
}

bool BoardEmulator::any_motor_on() const {
  return std::any_of(boards_.begin(), boards_.end(),
                     [](const Connected& b) { return b.board.any_motor_on(); });
}

void BoardEmulator::unplug(std::size_t i) {
  if (boards_[i].plugged() && !link_directory_.empty()) ::unlink(link(i).c_str());
  boards_[i].pty = {};
  boards_[i].host.reset();
  boards_[i].listener.reset();
  boards_[i].stream.clear();
}

Status BoardEmulator::plug(std::size_t i) {
  if (line_ == LineKind::socket) {
    unplug(i);
    auto listener = listen_local(link(i));
    if (!listener) return Failure(listener.error());
    boards_[i].listener = std::move(*listener);
    return {};
  }
  auto pty = open_pseudo_terminal();
  if (!pty) return Failure(pty.error());
  unplug(i);
  if (!link_directory_.empty()) {
    const std::string path = link(i);
    ::unlink(path.c_str());  // left behind by a killed run
    if (::symlink(pty->path.c_str(), path.c_str()) != 0) {
      return bad_input(std::string("cannot make the link: ") + std::strerror(errno), path,
                       "Give an existing, writable link_directory");
    }
  }
  boards_[i].pty = std::move(*pty);
  return {};
}

bool BoardEmulator::inject_noise(std::size_t i, std::span<const std::uint8_t> bytes) {
  return boards_[i].line() >= 0 && boards_[i].stream.queue(bytes);
}

void BoardEmulator::wait(double timeout_s) const {
  std::vector<int> fds;
  for (const auto& b : boards_) fds.push_back(b.line());
  wait_readable(fds, timeout_s);
}

void BoardEmulator::Connected::meet_host() {
  if (!listener.is_open() || host.is_open()) return;
  host = accept_local(listener);
  stream.clear();
}

/// A host may hang up: the board stays powered and waits for the next one. A pseudo terminal that breaks is
/// an error.
Status BoardEmulator::Connected::kept(Status moved) {
  if (moved || !listener.is_open()) return moved;
  host.reset();
  stream.clear();
  return {};
}

Status BoardEmulator::receive(double now_s) {
  if (!std::isfinite(now_s)) return bad_input("time is not finite", "BoardEmulator", "Check the clock");
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    auto& b = boards_[i];
    b.meet_host();
    if (b.line() < 0) continue;
    bytes_.clear();
    answers_.clear();
    if (auto ok = b.kept(b.stream.read(b.line(), bytes_)); !ok) return ok;
    if (on_received_ && !bytes_.empty()) on_received_(i, bytes_);
    b.board.receive(bytes_, now_s, answers_);
    if (!b.stream.queue(answers_)) dropped_ += frames_in(answers_);
  }
  return {};
}

Status BoardEmulator::step(double now_s) {
  if (auto ok = receive(now_s); !ok) return ok;
  for (auto& b : boards_) {
    b.board.update(now_s);
    const auto& config = b.board.config();
    for (std::size_t k = 0; k < config.rotors; ++k) command_[config.rotor_offset + k] = b.board.target(k);
  }
  plant_->set_command(command_);
  const PlantSample sample = plant_->sample();
  for (auto& b : boards_) {
    bytes_.clear();
    b.board.emit(now_s, sample, bytes_);
    if (b.line() < 0) continue;
    if (!b.stream.queue(bytes_)) dropped_ += frames_in(bytes_);
    if (auto ok = b.kept(b.stream.flush(b.line())); !ok) return ok;
  }
  return {};
}

}  // namespace omniflight::gateway
