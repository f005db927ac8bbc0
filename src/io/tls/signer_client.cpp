// SPDX-License-Identifier: Apache-2.0
#include "io/tls/signer_client.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fmt/core.h>
#include <map>
#include <system_error>
#include <utility>

#include "io/clock.hpp"

namespace mbgate::io {
namespace {

using signing::Answer;
using signing::Question;

using std::chrono::milliseconds;

/// A signer that systemd starts now needs some time.
constexpr milliseconds kOpenLimit{2000};
/// A signature of RSA with 8192 bits takes some 30 ms; more is a signer that hangs. All clients of
/// TLS wait meanwhile.
constexpr milliseconds kSignLimit{200};
/// How long a signer that did not answer in time is not asked again.
constexpr milliseconds kBroken{1000};
constexpr const char* kNoAnswer = "mbgate-signer does not answer";

/// Which signers have not answered in time, and when. It is the process that hangs, so the keys of
/// all clients and lines know it.
class SilentSigners {
 public:
  void note(const std::string& path, bus::Instant at) {
    const std::lock_guard lock(mutex_);
    since_[path] = at;
  }
  [[nodiscard]] bool has(const std::string& path, bus::Instant at) {
    const std::lock_guard lock(mutex_);
    const auto since = since_.find(path);
    return since != since_.end() && at < since->second + kBroken;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, bus::Instant> since_;
};

SilentSigners& silent_signers() {
  static SilentSigners signers;
  return signers;
}

/// What the socket does next may take until then. False: the time is over.
bool limit_waiting(const sys::UniqueFd& socket, bus::Instant limit) {
  const auto left = std::chrono::duration_cast<std::chrono::microseconds>(limit - now());
  if (left.count() <= 0) {
    errno = EAGAIN;
    return false;
  }
  const timeval time{.tv_sec = left.count() / 1'000'000, .tv_usec = left.count() % 1'000'000};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &time, sizeof time);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &time, sizeof time);
  return true;
}

/// Waits too, if the signer has many connections that it has not taken yet.
sys::UniqueFd connect_to(const std::string& path, bus::Instant limit) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    return {};
  }
  std::ranges::copy(path, address.sun_path);
  sys::UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const bool connected =
      limit_waiting(socket, limit) &&
      ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  return connected ? std::move(socket) : sys::UniqueFd();
}

/// What belongs to an answer of this kind; nothing if it is another.
std::optional<Octets> part_of(const Octets& answer, Answer kind) {
  if (answer.empty() || answer.front() != static_cast<std::uint8_t>(kind)) {
    return std::nullopt;
  }
  return Octets(answer.begin() + 1, answer.end());
}

}  // namespace

SignerClient::Failure SignerClient::absent(const std::string& why) const {
  return {fmt::format("mbgate-signer ({}): {}", path_, why), true};
}

Result<std::shared_ptr<SignerClient>, SignerClient::Failure> SignerClient::open(std::string socket,
                                                                                std::string key) {
  const std::shared_ptr<SignerClient> client(new SignerClient(std::move(socket), std::move(key)));
  auto opened = client->connect(now() + kOpenLimit);
  if (!opened) {
    return opened.error();
  }
  client->public_key_ = *std::move(opened);
  return client;
}

Result<Octets, SignerClient::Failure> SignerClient::connect(bus::Instant limit) {
  socket_ = connect_to(path_, limit);
  if (!socket_.is_open()) {
    return absent(std::generic_category().message(errno));
  }
  const auto answer = ask(Question::open, Octets(key_.begin(), key_.end()), limit);
  if (!answer) {
    return absent("no answer: " + std::generic_category().message(errno));
  }
  if (auto key = part_of(*answer, Answer::opened)) {
    return *std::move(key);
  }
  const auto why = part_of(*answer, Answer::refused);
  return Failure{
      fmt::format("mbgate-signer: {}", why ? std::string(why->begin(), why->end())
                                           : std::string("its answer is not understood"))};
}

std::optional<Octets> SignerClient::ask(Question question, std::span<const std::uint8_t> bytes,
                                        bus::Instant limit) {
  Octets message = {static_cast<std::uint8_t>(question)};
  message.insert(message.end(), bytes.begin(), bytes.end());
  std::array<std::uint8_t, signing::kLargestMessage> answer{};
  const bool sent = limit_waiting(socket_, limit) &&
                    ::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL) >= 0;
  const bool waits = sent && limit_waiting(socket_, limit);
  const ssize_t size = waits ? ::recv(socket_.get(), answer.data(), answer.size(), 0) : -1;
  if (size <= 0) {
    const int error = size == 0 ? ECONNRESET : errno;
    socket_.reset();  // an answer that comes late would be taken for the next one
    errno = error;
    return std::nullopt;
  }
  return Octets(answer.begin(), answer.begin() + size);
}

Result<Octets, std::string> SignerClient::sign(Question how, std::span<const std::uint8_t> bytes) {
  const bus::Instant begin = now();
  if (silent_signers().has(path_, begin)) {
    return std::string(kNoAnswer);
  }
  const bus::Instant limit = begin + kSignLimit;
  const std::lock_guard lock(mutex_);
  auto answer = socket_.is_open() ? ask(how, bytes, limit) : std::nullopt;
  std::optional<std::string> wrong;
  if (!answer) {
    wrong = open_again(limit);
    answer = wrong ? std::nullopt : ask(how, bytes, limit);
  }
  if (!answer && now() >= limit) {
    silent_signers().note(path_, now());
    return std::string(kNoAnswer);
  }
  if (auto signature = answer ? part_of(*answer, Answer::signature) : std::nullopt) {
    return *std::move(signature);
  }
  return wrong ? *std::move(wrong) : std::string("mbgate-signer refuses to sign");
}

/// Why not.
std::optional<std::string> SignerClient::open_again(bus::Instant limit) {
  const auto opened = connect(limit);
  if (!opened) {
    return opened.error().why;
  }
  if (*opened != public_key_) {
    socket_.reset();
    return fmt::format("mbgate-signer: {} is another key now", key_);
  }
  return std::nullopt;
}

}  // namespace mbgate::io
