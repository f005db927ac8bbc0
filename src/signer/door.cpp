// SPDX-License-Identifier: Apache-2.0
#include "signer/door.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iostream>
#include <utility>

namespace mbgate::signer {
namespace {

using signing::Answer;
using signing::Question;

Octets answer_of(Answer kind, std::span<const std::uint8_t> bytes) {
  Octets answer = {static_cast<std::uint8_t>(kind)};
  answer.insert(answer.end(), bytes.begin(), bytes.end());
  answer.resize(std::min(answer.size(), signing::kLargestMessage));
  return answer;
}

Octets refusal(std::string_view why) {
  return answer_of(Answer::refused, Octets(why.begin(), why.end()));
}

/// The journal says what was not signed: mbgated asks for nothing of the kind by itself.
Octets signature_or_refusal(const std::optional<KeyFile>& key, Question how,
                            std::span<const std::uint8_t> bytes) {
  if (!key) {
    return refusal("no key was opened");
  }
  if (const auto why = key->objection(how, bytes); !why.empty()) {
    std::cerr << key->name() << ": not signed: " << bytes.size() << " bytes, " << why << '\n';
    return refusal(why);
  }
  const auto signature = key->sign(how, bytes);
  return signature ? answer_of(Answer::signature, *signature) : refusal("OpenSSL does not sign it");
}

}  // namespace

void Door::run(const sigset_t& mask, const volatile std::sig_atomic_t& ended) {
  while (ended == 0) {
    std::vector<pollfd> watched = {{listening_, POLLIN, 0}};
    for (const Connection& connection : connections_) {
      watched.push_back({connection.socket.get(), POLLIN, 0});
    }
    if (::ppoll(watched.data(), watched.size(), nullptr, &mask) < 0) {
      continue;  // a signal
    }
    std::vector<Connection> kept;
    for (std::size_t i = 0; i < connections_.size(); ++i) {
      if (watched[i + 1].revents == 0 || answer(connections_[i])) {
        kept.push_back(std::move(connections_[i]));
      }
    }
    connections_ = std::move(kept);
    if (watched[0].revents != 0) {
      accept();
    }
  }
}

void Door::accept() {
  sys::UniqueFd socket(::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.is_open()) {
    return;
  }
  if (connections_.size() >= kMostConnections) {
    std::cerr << "more than " << kMostConnections << " connections: one was closed\n";
    return;
  }
  connections_.push_back({std::move(socket), std::nullopt});
}

bool Door::answer(Connection& connection) const {
  // One byte more than the largest: what is longer shows.
  std::array<std::uint8_t, signing::kLargestMessage + 1> message{};
  const ssize_t size = ::recv(connection.socket.get(), message.data(), message.size(), 0);
  if (size < 0) {
    return errno == EAGAIN || errno == EINTR;
  }
  if (size == 0) {
    return false;
  }
  const auto said = std::span<const std::uint8_t>(message).first(static_cast<std::size_t>(size));
  const Octets answer = answer_to(connection, said);
  return ::send(connection.socket.get(), answer.data(), answer.size(), MSG_NOSIGNAL) >= 0;
}

Octets Door::answer_to(Connection& connection, std::span<const std::uint8_t> said) const {
  if (said.size() > signing::kLargestMessage) {
    return refusal("the question is too long");
  }
  const auto question = static_cast<Question>(said[0]);
  const auto rest = said.subspan(1);
  switch (question) {
    case Question::open: {
      auto opened = KeyFile::open(store_, std::string(rest.begin(), rest.end()));
      connection.key = std::move(opened.key);
      if (!connection.key) {
        std::cerr << opened.why << '\n';
        return refusal(opened.why);
      }
      return answer_of(Answer::opened, connection.key->public_key());
    }
    case Question::rsa_pkcs1:
    case Question::rsa_padded:
    case Question::ecdsa: return signature_or_refusal(connection.key, question, rest);
  }
  return refusal("the question is not understood");
}

}  // namespace mbgate::signer
