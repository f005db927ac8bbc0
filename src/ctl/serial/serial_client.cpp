// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_client.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <system_error>

#include "sys/tty.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

/// So long a pause ends what is heard: an FTDI chip holds bytes back for up to 16 ms, and its
/// packets may arrive that much apart.
constexpr std::chrono::milliseconds kPieces{20};
/// A line that never falls silent is listened to no longer: an echo, a frame, and one more.
constexpr std::size_t kMostHeard = 2 * modbus::kMaxRtuSize + 8;
/// So often whoever asks is asked whether it is over.
constexpr std::chrono::milliseconds kSlice{100};

/// Is there something to read, or an error, before `until`?
bool wait_readable(int fd, steady_clock::time_point until) {
  while (true) {
    const auto time =
        sys::timespec_of(std::max<nanoseconds>(until - steady_clock::now(), nanoseconds(0)));
    pollfd watched{fd, POLLIN, 0};
    const int ready = ::ppoll(&watched, 1, &time, nullptr);
    if (ready >= 0 || errno != EINTR) {
      return ready != 0;
    }
  }
}

std::string gone_text(const std::string& device, int error) {
  return device + ": the port has disappeared" +
         (error == 0 ? std::string() : ": " + std::generic_category().message(error));
}

}  // namespace

Result<SerialClient, int> SerialClient::open(const std::string& device) {
  auto port = SerialPort::open(device);
  if (!port) {
    return port.error();
  }
  return SerialClient(device, *std::move(port));
}

std::optional<std::string> SerialClient::set_mode(const LineMode& mode) {
  mode_ = mode;
  ready_at_ = steady_clock::now() + kModeSettling;
  return port_.set_mode(mode);
}

std::optional<std::string> SerialClient::send(modbus::Bytes frame) {
  const auto written = ::write(port_.descriptor(), frame.data(), frame.size());
  if (written == static_cast<ssize_t>(frame.size())) {
    return std::nullopt;
  }
  return written >= 0 || errno == EAGAIN ? device_ + ": the port takes no bytes"
                                         : gone_text(device_, errno);
}

bool SerialClient::is_full() const { return received_.size() >= kMostHeard; }

Result<std::optional<Piece>, std::string> SerialClient::take_piece(Instant begin, Instant until) {
  while (!is_full() && wait_readable(port_.descriptor(), until)) {
    std::array<std::uint8_t, modbus::kMaxRtuSize> bytes{};
    const auto size = ::read(port_.descriptor(), bytes.data(), bytes.size());
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) {
      continue;
    }
    if (size <= 0) {
      return gone_text(device_, size == 0 ? 0 : errno);
    }
    last_received_ = steady_clock::now();
    received_.insert(received_.end(), bytes.begin(), bytes.begin() + size);
    return std::optional(Piece{last_received_ - begin, {bytes.begin(), bytes.begin() + size}});
  }
  return std::optional<Piece>();
}

Result<std::vector<Piece>, std::string> SerialClient::take_pieces(Instant begin, Instant end,
                                                                  const NextEnd& next_end,
                                                                  const IsOver& is_over) {
  received_.clear();
  std::vector<Piece> pieces;
  while (true) {
    const auto slice_end = std::min<Instant>(end, steady_clock::now() + kSlice);
    auto piece = take_piece(begin, slice_end);
    if (!piece) {
      return piece.error();
    }
    if (*piece) {
      pieces.push_back(**std::move(piece));
      const auto next = next_end(end);
      if (!next) {
        return pieces;
      }
      end = *next;
    } else if (slice_end == end) {
      return pieces;
    }
    if (is_full() || is_over()) {
      return pieces;
    }
  }
}

void SerialClient::rest(nanoseconds pause) {
  const modbus::RtuTiming timing(mode_.baud, mode_.format);
  ready_at_ = steady_clock::now() + std::max<nanoseconds>(timing.t3_5(), pause);
}

Result<Heard, std::string> SerialClient::ask(std::uint8_t unit, const modbus::TableRange& read,
                                             nanoseconds wait) {
  const SentRead sent(unit, read);
  const modbus::RtuTiming timing(mode_.baud, mode_.format);
  sys::discard_all(port_.descriptor());
  const auto begin = steady_clock::now();
  last_received_ = begin;
  if (auto error = send(sent.frame())) {
    return *std::move(error);
  }
  const auto until = begin + timing.duration_of(sent.frame().size()) + wait;
  const auto quiet = std::max<nanoseconds>(kPieces, timing.t3_5());
  const auto next_end = [&](Instant /*end*/) {
    // After other bytes the answer may still come.
    return sent.answer_in(received()) ? std::nullopt
                                      : std::optional(std::max(until, last_received_ + quiet));
  };
  if (const auto pieces = take_pieces(until, until, next_end); !pieces) {
    return pieces.error();
  }
  auto heard = sent.understand(received());
  heard.took = last_received_ - begin;
  const bool understood = heard.kind == HeardKind::answer || heard.kind == HeardKind::silence;
  rest(understood ? nanoseconds(0) : nanoseconds(kPauseAfterNoise));
  return heard;
}

Result<std::vector<Piece>, std::string> SerialClient::ask_all(const SentRead& sent,
                                                              const ListenTimes& times,
                                                              const IsOver& is_over) {
  const modbus::RtuTiming timing(mode_.baud, mode_.format);
  const auto left = steady_clock::now() + timing.duration_of(sent.frame().size());
  if (auto error = send(sent.frame())) {
    return *std::move(error);
  }
  const Instant answered_by = left + times.wait;
  const Instant latest = answered_by + timing.duration_of(modbus::kMaxRtuSize) + times.after_bytes;
  const auto next_end = [&](Instant /*end*/) {
    const Instant end = sent.answer_in(received())
                            ? last_received_ + times.after_answer
                            : std::max<Instant>(answered_by, last_received_ + times.after_bytes);
    return std::optional(std::min(end, latest));
  };
  auto pieces = take_pieces(left, answered_by, next_end, is_over);
  rest(kPauseAfterNoise);
  return pieces;
}

Result<std::vector<Piece>, std::string> SerialClient::overhear(nanoseconds time) {
  const auto begin = steady_clock::now();
  auto pieces = take_pieces(begin, begin + time, [](Instant end) { return std::optional(end); });
  rest(nanoseconds(0));
  return pieces;
}

}  // namespace mbgate::ctl
