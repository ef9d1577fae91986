#include "omniflight_gateway/board_link.hpp"

#include <termios.h>

#include <charconv>

namespace omniflight::gateway {
namespace {

struct KnownBoard {
  BoardKind kind;
  std::string_view name;
  double oldest_version;
  std::size_t skip;  ///< characters before the name
};
constexpr KnownBoard kKnownBoards[] = {
    {BoardKind::chimera, "chimera", 1.1, 0}, {BoardKind::teensy, "teensy", 1.1, 0},
    {BoardKind::mkfl, "mkfl", 1.8, 0},       {BoardKind::flymu, "flymu", 1.8, 0},
    {BoardKind::mkbl, "mkbl", 1.8, 1},
};

std::string cleaned(std::string_view text) {
  std::string out;
  for (const char c : text) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out;
}

}  // namespace

std::string_view to_string(BoardKind kind) {
  for (const auto& board : kKnownBoards) {
    if (board.kind == kind) return board.name;
  }
  return "unknown";
}

bool has_imu(BoardKind kind) {
  return kind == BoardKind::chimera || kind == BoardKind::flymu || kind == BoardKind::mkfl;
}
bool has_motors(BoardKind kind) {
  return kind == BoardKind::teensy || kind == BoardKind::mkfl || kind == BoardKind::mkbl;
}
ImuScale imu_scale(BoardKind kind) { return kind == BoardKind::chimera ? chimera_imu_scale() : ImuScale{}; }

Result<BoardKind> identify(std::string_view id) {
  for (const auto& board : kKnownBoards) {
    if (id.size() < board.skip || !id.substr(board.skip).starts_with(board.name)) continue;
    const std::string_view digits = id.substr(board.skip + board.name.size());
    double version = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), version);
    if (error != std::errc{}) break;
    if (version < board.oldest_version) {
      return bad_input("firmware " + cleaned(id) + " is older than " + std::to_string(board.oldest_version),
                       "board id", "Update the board's firmware");
    }
    return board.kind;
  }
  return bad_input("unknown board '" + cleaned(id) + "'", "board id",
                   "Supported are chimera >= 1.1, teensy >= 1.1, mkfl, flymu and mkbl >= 1.8");
}

Failure BoardLink::failure(std::string message, std::string next) const {
  return bad_input(std::move(message), config_.device, std::move(next));
}

Status BoardLink::open(double now_s) {
  close();
  error_.reset();
  auto fd = open_serial(config_.device, config_.baud);
  if (!fd) {
    error_ = fd.error();
    return Failure(*error_);
  }
  fd_ = std::move(*fd);
  kind_ = BoardKind::unknown;
  id_.clear();
  decoder_.reset();
  asked_ = 0;
  heard_s_ = moved_s_ = now_s;
  return ask(now_s);
}

void BoardLink::close() {
  if (is_open()) {
    (void)stream_.flush(fd_.get());
    // What a broken line never takes must not hold up close() (serial drivers wait for it).
    if (error_) tcflush(fd_.get(), TCOFLUSH);
  }
  fd_.reset();
  stream_.clear();
  velocity_.reset();
  expects_traffic_ = false;
}

Status BoardLink::ask(double now_s) {
  if (asked_ == config_.id_attempts) {
    return failure("no board answered " + std::to_string(asked_) + " id queries",
                   "Check that the board is powered and runs the telekyb3 firmware");
  }
  ++asked_;
  asked_s_ = now_s;
  return send(IdQuery{});
}

Status BoardLink::send(const HostMessage& message) {
  if (!is_open()) return error_ ? Status(Failure(*error_)) : failure("is not open", "Connect first");
  const Wire wire = to_wire(message);
  if (std::holds_alternative<VelocityCommand>(message)) {
    if (velocity_) ++superseded_commands_;
    velocity_ = wire;
    return {};
  }
  if (std::holds_alternative<StopMotors>(message)) velocity_.reset();  // nothing may follow a stop
  if (!stream_.queue(wire.view())) return failure("the line does not take more output", "Check the cable");
  return {};
}

void BoardLink::expect_traffic(double now_s) {
  expects_traffic_ = true;
  heard_s_ = now_s;
}

Status BoardLink::receive(std::vector<BoardMessage>& received, double now_s) {
  bytes_.clear();
  const Status read = stream_.read(fd_.get(), bytes_);
  for (const std::uint8_t byte : bytes_) {
    if (!decoder_.push(byte)) continue;
    auto message = decode_board(decoder_.body());
    if (!message) {
      ++refused_messages_;
      continue;
    }
    heard_s_ = now_s;
    const auto* reply = std::get_if<IdReply>(&*message);
    if (reply == nullptr) {
      received.push_back(std::move(*message));
    } else if (!identified()) {
      const auto kind = identify(reply->text);
      // A reply mangled on the line looks like an unknown board: only the last attempt's answer is final.
      if (!kind && asked_ == config_.id_attempts)
        return failure(kind.error().message, kind.error().next_step);
      if (!kind) continue;
      kind_ = *kind;
      id_ = reply->text;
    }
  }
  if (!read) return failure(read.error().message, read.error().next_step);
  return {};
}

Status BoardLink::transmit(double now_s) {
  if (stream_.pending() == 0 && velocity_) {
    stream_.queue(velocity_->view());
    velocity_.reset();
  }
  const std::size_t before = stream_.pending();
  const Status written = stream_.flush(fd_.get());
  if (!written) return failure(written.error().message, written.error().next_step);
  if (before == 0 || stream_.pending() < before) moved_s_ = now_s;
  if (now_s - moved_s_ > config_.write_stall_s) {
    return failure("the line took no byte for " + std::to_string(config_.write_stall_s) + " s",
                   "Check the cable");
  }
  return {};
}

Status BoardLink::serve(double now_s, std::vector<BoardMessage>& received) {
  if (auto ok = receive(received, now_s); !ok) return ok;
  if (!identified() && now_s - asked_s_ >= config_.id_retry_s) {
    if (auto ok = ask(now_s); !ok) return ok;
  }
  if (auto ok = transmit(now_s); !ok) return ok;
  if (expects_traffic_ && config_.silence_s > 0 && now_s - heard_s_ > config_.silence_s) {
    return failure("the board has been silent for " + std::to_string(config_.silence_s) + " s",
                   "Check its power, then connect again");
  }
  return {};
}

Status BoardLink::poll(double now_s, std::vector<BoardMessage>& received) {
  if (error_) return Failure(*error_);
  if (!is_open()) return failure("is not open", "Connect first");
  if (auto ok = serve(now_s, received); !ok) {
    error_ = ok.error();
    close();
    return ok;
  }
  return {};
}

}  // namespace omniflight::gateway
