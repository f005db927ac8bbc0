// SPDX-License-Identifier: Apache-2.0
#include "sim/program/pty.hpp"

#include <fcntl.h>

#include <array>
#include <cerrno>
#include <fmt/core.h>
#include <system_error>

#include "sys/tty.hpp"

namespace mbgate::sim {
namespace {

namespace fs = std::filesystem;

std::string reason() { return std::generic_category().message(errno); }

/// What stands at `link` after all that may be replaced is gone: an error text, or nothing.
std::optional<std::string> clear_place(const fs::path& link, const std::string& target) {
  std::error_code error;
  const auto found = fs::symlink_status(link, error);
  if (!fs::exists(found)) {
    return std::nullopt;
  }
  const bool replaceable = fs::is_symlink(found) &&
                           (fs::read_symlink(link, error) == target || !fs::exists(link, error));
  if (!replaceable) {
    return fmt::format("link {} already exists, and is in use or not a link; remove it",
                       link.string());
  }
  if (!fs::remove(link, error)) {
    return fmt::format("link {} cannot be replaced: {}", link.string(), error.message());
  }
  return std::nullopt;
}

std::optional<std::string> make_link(const fs::path& link, const std::string& target) {
  if (auto refusal = clear_place(link, target)) {
    return refusal;
  }
  std::error_code error;
  fs::create_symlink(target, link, error);
  if (error) {
    return fmt::format("link {} cannot be made: {}", link.string(), error.message());
  }
  return std::nullopt;
}

bool make_raw(int port, PtySpeed speed) {
  sys::TtyMode mode;
  mode.baud = static_cast<std::uint32_t>(speed.baud);
  mode.stop_bits = speed.stop_bits;
  return sys::set_tty_mode(port, mode).has_value();
}

}  // namespace

Result<Pty, std::string> Pty::open(const fs::path& link, PtySpeed speed) {
  sys::UniqueFd controller(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  std::array<char, 64> path{};
  if (controller.get() < 0 || ::grantpt(controller.get()) != 0 ||
      ::unlockpt(controller.get()) != 0 ||
      ::ptsname_r(controller.get(), path.data(), path.size()) != 0) {
    return fmt::format("no pty for {}: {}", link.string(), reason());
  }
  sys::UniqueFd port(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (port.get() < 0 || !make_raw(port.get(), speed)) {
    return fmt::format("{}: {}", path.data(), reason());
  }
  if (auto refusal = make_link(link, path.data())) {
    return *std::move(refusal);
  }
  return Pty(std::move(controller), std::move(port), path.data(), link);
}

Pty::Pty(sys::UniqueFd controller, sys::UniqueFd port, std::string path, fs::path link)
    : controller_(std::move(controller)),
      port_(std::move(port)),
      path_(std::move(path)),
      link_(std::move(link)) {}

Pty::~Pty() {
  std::error_code error;
  if (controller_.get() >= 0 && fs::read_symlink(link_, error) == path_) {
    fs::remove(link_, error);
  }
}

std::vector<std::uint8_t> Pty::read() const {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 1024> part{};
  for (;;) {
    const ssize_t size = ::read(controller_.get(), part.data(), part.size());
    if (size <= 0) {
      return bytes;
    }
    bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    if (static_cast<std::size_t>(size) < part.size()) {
      return bytes;
    }
  }
}

void Pty::write(modbus::Bytes bytes) const {
  while (!bytes.empty()) {
    const ssize_t size = ::write(controller_.get(), bytes.data(), bytes.size());
    if (size <= 0) {
      return;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
}

std::optional<PtySpeed> Pty::speed() const {
  const auto mode = sys::tty_mode(port_.get());
  return mode ? std::optional(PtySpeed{modbus::Baud{mode->baud}, mode->stop_bits}) : std::nullopt;
}

void Pty::release_exclusive() const { sys::release_tty(port_.get()); }

}  // namespace mbgate::sim
