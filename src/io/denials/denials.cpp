// SPDX-License-Identifier: Apache-2.0
#include "io/denials/denials.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>

#include "io/denials/advice.hpp"

namespace mbgate::io {
namespace {

std::string said(int error) { return std::generic_category().message(error); }

bool is_v6(const std::string& address) { return address.find(':') != std::string::npos; }

class Examination {
 public:
  Examination(const Attempts& attempts, Starter starter)
      : attempts_(attempts),
        starter_(starter),
        v4_(attempts.socket(AF_INET)),
        v6_(attempts.socket(AF_INET6)) {}

  /// Why this process cannot listen there; nothing if it can, or if it may become possible.
  [[nodiscard]] std::optional<std::string> of_listening(const gateway::ListenerSettings& listener,
                                                        SocketUnit shipped) const {
    const bool v6 = is_v6(listener.address);
    const FamilyErrors errors{v6 ? v6_ : v4_, v4_};
    const std::string where = "cannot listen on " +
                              (v6 ? "[" + listener.address + "]" : listener.address) + ":" +
                              std::to_string(listener.port) + ": ";
    if (is_denial(errors.wanted)) {
      return where + said(errors.wanted) + listen_advice(listener, errors, shipped, starter_);
    }
    const int error = listener.port == 0 ? 0 : attempts_.bind(listener);
    if (is_denial(error)) {
      return where + said(error) + port_advice(listener, error, shipped, starter_);
    }
    return std::nullopt;
  }

  /// Why it cannot connect to this host. A name may stand for addresses of both families.
  [[nodiscard]] std::optional<std::string> of_connecting(const std::string& host) const {
    boost::system::error_code is_name;
    const auto address = boost::asio::ip::make_address(host, is_name);
    const int error = is_name ? (is_denial(v6_) ? v4_ : 0) : (address.is_v6() ? v6_ : v4_);
    if (!is_denial(error)) {
      return std::nullopt;
    }
    return said(error) + connect_advice({error, v4_}, starter_);
  }

  /// Why nothing can be made there. Where the folder itself is missing, it may come.
  [[nodiscard]] std::optional<std::string> of_control_socket(const std::string& path) const {
    const auto parent = std::filesystem::path(path).parent_path();
    const std::string folder = parent.empty() ? "." : parent.string();
    const int error = attempts_.folder(folder);
    if (error != EROFS && !is_denial(error)) {
      return std::nullopt;
    }
    return said(error) + folder_advice(folder, error, "choose a path below /run/mbgate", starter_);
  }

 private:
  const Attempts& attempts_;
  Starter starter_;
  int v4_;
  int v6_;
};

/// The key that says where the far end of a bus is.
std::string key_of(const bus::LineSettings& line) {
  return line.framing == bus::Framing::tcp ? "host = \"" + line.remote->host + "\""
                                           : "device = \"" + line.device + "\"";
}

bool is_named(const gateway::Settings& settings, const std::string& listener) {
  return std::ranges::find(settings.listeners, listener, &gateway::ListenerSettings::name) !=
         settings.listeners.end();
}

}  // namespace

std::vector<std::string> denials(const gateway::Settings& settings,
                                 const std::set<std::string>& from_systemd,
                                 const Attempts& attempts, Starter starter) {
  const Examination examination(attempts, starter);
  std::vector<std::string> found;
  const auto note = [&](const std::string& key, const std::optional<std::string>& why) {
    if (why) {
      found.push_back(key + ": " + *why);
    }
  };
  const auto is_inherited = [&](const auto& it) { return from_systemd.contains(it.name); };
  bool is_taken = std::ranges::any_of(settings.listeners, is_inherited);
  for (const auto& listener : settings.listeners) {
    if (!is_inherited(listener)) {
      note("listener \"" + listener.name + "\": port = " + std::to_string(listener.port),
           examination.of_listening(listener, is_taken ? SocketUnit::taken : SocketUnit::free));
      is_taken = is_taken || !found.empty();
    }
  }
  const bool is_http_inherited = from_systemd.contains("http") && !is_named(settings, "http");
  for (const auto& listen : settings.http.listen) {
    gateway::ListenerSettings listener;
    listener.name = "http";
    listener.address = listen.address.to_text();
    listener.port = listen.port;
    if (!is_http_inherited) {
      note("[http] listen", examination.of_listening(listener, SocketUnit::free));
    }
  }
  const std::string& control = settings.control_socket;
  if (!control.empty() && control != gateway::Settings{}.control_socket) {
    note("[http] socket = \"" + control + "\"", examination.of_control_socket(control));
  }
  for (const auto& bus : settings.buses) {
    if (bus.line.remote) {
      note("bus \"" + bus.name + "\": " + key_of(bus.line),
           examination.of_connecting(bus.line.remote->host));
    }
  }
  return found;
}

}  // namespace mbgate::io
