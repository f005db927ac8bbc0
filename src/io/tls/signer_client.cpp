// SPDX-License-Identifier: Apache-2.0
#include "io/tls/signer_client.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace mbgate::io {
namespace {

using signing::Answer;
using signing::Question;

/// A signature of RSA with 8192 bits takes some 30 ms; more is a signer that hangs.
constexpr timeval kSignerPatience{.tv_sec = 2, .tv_usec = 0};

UniqueFd connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    return {};
  }
  std::ranges::copy(path, address.sun_path);
  UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &kSignerPatience, sizeof kSignerPatience);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &kSignerPatience, sizeof kSignerPatience);
  const bool connected =
      ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  return connected ? std::move(socket) : UniqueFd();
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
  return {"mbgate-signer (" + path_ + "): " + why, true};
}

Result<std::shared_ptr<SignerClient>, SignerClient::Failure> SignerClient::open(std::string socket,
                                                                                std::string key) {
  const std::shared_ptr<SignerClient> client(new SignerClient(std::move(socket), std::move(key)));
  auto opened = client->connect();
  if (!opened) {
    return opened.error();
  }
  client->public_key_ = *std::move(opened);
  return client;
}

Result<Octets, SignerClient::Failure> SignerClient::connect() {
  socket_ = connect_to(path_);
  if (!socket_.is_open()) {
    return absent(std::generic_category().message(errno));
  }
  const auto answer = ask(Question::open, Octets(key_.begin(), key_.end()));
  if (!answer) {
    return absent("no answer: " + std::generic_category().message(errno));
  }
  if (auto key = part_of(*answer, Answer::opened)) {
    return *std::move(key);
  }
  const auto why = part_of(*answer, Answer::refused);
  return Failure{"mbgate-signer: " + (why ? std::string(why->begin(), why->end())
                                          : std::string("its answer is not understood"))};
}

std::optional<Octets> SignerClient::ask(Question question, std::span<const std::uint8_t> bytes) {
  Octets message = {static_cast<std::uint8_t>(question)};
  message.insert(message.end(), bytes.begin(), bytes.end());
  std::array<std::uint8_t, signing::kLargestMessage> answer{};
  if (::send(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL) < 0) {
    socket_.reset();
    return std::nullopt;
  }
  const ssize_t size = ::recv(socket_.get(), answer.data(), answer.size(), 0);
  if (size <= 0) {
    socket_.reset();  // an answer that comes late would be taken for the next one
    return std::nullopt;
  }
  return Octets(answer.begin(), answer.begin() + size);
}

std::optional<Octets> SignerClient::sign(Question how, std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(mutex_);
  auto answer = socket_.is_open() ? ask(how, bytes) : std::nullopt;
  if (!answer) {
    const auto opened = connect();
    if (!opened || *opened != public_key_) {
      socket_.reset();
      return std::nullopt;
    }
    answer = ask(how, bytes);
  }
  return answer ? part_of(*answer, Answer::signature) : std::nullopt;
}

}  // namespace mbgate::io
