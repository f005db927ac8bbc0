// SPDX-License-Identifier: Apache-2.0
#include "subject.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "floors.hpp"

namespace mbgate::bench {
namespace {

constexpr std::chrono::seconds kStartLimit{10};
constexpr std::chrono::milliseconds kLook{10};
constexpr const char* kSigner = "signer.socket";

struct Listening {
  sys::UniqueFd socket;
  std::uint16_t port;
};

/// On 127.0.0.1, at a port that the kernel chooses.
Listening listen_somewhere() {
  sys::UniqueFd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the way of the socket interface
  auto* place = reinterpret_cast<sockaddr*>(&address);
  if (socket.get() < 0 || ::bind(socket.get(), place, size) != 0 ||
      ::listen(socket.get(), 1024) != 0 || ::getsockname(socket.get(), place, &size) != 0) {
    throw std::system_error(errno, std::generic_category(), "listen");
  }
  return {std::move(socket), ntohs(address.sin_port)};
}

std::string line_name(std::size_t bus) { return "line-" + std::to_string(bus); }

enum class Encrypted { no, yes };

void add_listener(std::ostream& text, const std::string& name, std::size_t bus,
                  Encrypted encrypted = Encrypted::no) {
  text << "[[listen]]\nname = \"" << name << "\"\naddress = \"127.0.0.1\"\nport = 0\nbus = \""
       << line_name(bus)
       << "\"\nmax_connections = 20000\nmax_connections_per_address = "
          "20000\nmax_connects_per_second = 0\nmax_requests_per_second = 0\npipeline = 64\n"
       << (encrypted == Encrypted::yes ? "tls = \"bench\"\nmax_handshakes_per_second = 0\n"
                                         "max_handshakes_per_second_per_client = 0\n"
                                       : "");
}

/// The configuration for a plant: a listener a bus, and one for a flood.
std::string configuration(const Scenario& scenario, const std::filesystem::path& folder,
                          const std::vector<std::string>& paths) {
  std::ostringstream text;
  const LoadSettings& load = scenario.load;
  text << "[gateway]\nwake_early = \"" << scenario.wake_early << "us\"\n";
  if (load.speaks_tls()) {
    text << "signer = \"" << (folder / kSigner).string()
         << "\"\n[[tls]]\nname = \"bench\"\ncertificate = \"gateway.crt\"\n"
            "key = \"gateway.key\"\nauthorities = \"ca.crt\"\ncrl = \"ca.crl\"\n";
  }
  for (std::size_t bus = 0; bus < paths.size(); ++bus) {
    add_listener(text, line_name(bus), bus, load.tls ? Encrypted::yes : Encrypted::no);
    text << "[[bus]]\nname = \"" << line_name(bus) << "\"\ndevice = \"" << paths[bus]
         << "\"\nparity = \"none\"\nlow_latency = false\nlisten_first = \"0s\"\n"
         // Where all devices answer, a machine that stands still for a moment makes none of them
         // dead.
         << "response_timeout = \"" << (scenario.plant.dead > 0 ? "100ms" : "1s") << "\"\n"
         << "coalesce = " << (scenario.coalesce ? "true" : "false") << "\n";
    if (scenario.plant.paced()) {
      text << "baud = " << scenario.plant.baud << "\n";
    } else {
      text << "baud = 4000000\nframe_gap = \"0s\"\n";
    }
  }
  if (load.flood > 0) {
    add_listener(text, "flood", 0);
  }
  if (load.handshakes > 0) {
    add_listener(text, "handshakes", 0, Encrypted::yes);
  }
  return std::move(text).str();
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

/// Looks until `found` says so; false after the limit, or when the process has ended.
template <typename Found>
bool wait_until(const Child& child, Found found) {
  for (auto left = kStartLimit / kLook; left > 0; --left) {
    if (found()) {
      return true;
    }
    if (!child.lives()) {
      return false;
    }
    std::this_thread::sleep_for(kLook);
  }
  return false;
}

}  // namespace

void make_certificates(const std::filesystem::path& mbgate_cert,
                       const std::filesystem::path& folder) {
  const std::string make = "'" + mbgate_cert.string() + "' ";
  const std::string in = " --directory '" + folder.string() + "' >/dev/null";
  const std::string command = make + "ca" + in + " && " + make +
                              "server gateway --address 127.0.0.1" + in + " && " + make +
                              "client client --role bench" + in;
  if (std::system(command.c_str()) != 0) {  // NOLINT(cert-env33-c): of names that we were given
    throw std::runtime_error(mbgate_cert.string() + " made no certificates");
  }
}

Subject::Subject(const Scenario& scenario, const Means& means,
                 const std::vector<std::string>& paths)
    : log_(means.folder / "subject.log"),
      tls_files_{means.folder / "client.crt", means.folder / "client.key",
                 means.folder / "ca.crt"} {
  if (scenario.load.tls) {
    doors_.tls = tls_files_;
  }
  std::filesystem::remove(log_);  // of the run before
  if (scenario.program == "mbgated") {
    start_mbgated(scenario, means, paths);
    return;
  }
  if (scenario.program == "master") {
    child_.emplace(Child::run([&](int) { run_master(scenario.plant, paths); }));
    return;
  }
  if (paths.size() != 1 || scenario.load.flood > 0 || scenario.load.handshakes > 0) {
    throw std::runtime_error(scenario.name +
                             ": only mbgated and master take several buses, and "
                             "only mbgated has a listener for a flood or for handshakes");
  }
  if (scenario.program == "relay") {
    start_relay(scenario, paths[0]);
  } else {
    start_command(scenario, means, paths[0]);
  }
}

void Subject::start_mbgated(const Scenario& scenario, const Means& means,
                            const std::vector<std::string>& paths) {
  const auto config = means.folder / "mbgate.toml";
  std::ofstream(config) << configuration(scenario, means.folder, paths);
  if (scenario.load.speaks_tls()) {
    start_signer(means);
  }
  std::string command = "'" + means.mbgated.string() + "' --config '" + config.string() + "'";
  if (means.allocations) {
    counter_ = means.folder / "allocations";
    std::ofstream(counter_) << std::string(sizeof(std::uint64_t), '\0');
    command = "env LD_PRELOAD='" + means.allocations->string() + "' MBGATE_BENCH_ALLOCATIONS='" +
              counter_.string() + "' " + command;
  }
  child_.emplace(Child::command(command, log_));
  const auto port_of = [&](const std::string& name) -> std::uint16_t {
    const std::string sign = "listening " + name + " 127.0.0.1:";
    const std::string text = said();
    const auto at = text.find(sign);
    const bool whole = at != std::string::npos && text.find('\n', at) != std::string::npos;
    return whole ? static_cast<std::uint16_t>(std::stoul(text.substr(at + sign.size()))) : 0;
  };
  const LoadSettings& load = scenario.load;
  const auto listens = [&] {
    return port_of(line_name(paths.size() - 1)) != 0 &&
           (load.flood == 0 || port_of("flood") != 0) &&
           (load.handshakes == 0 || port_of("handshakes") != 0);
  };
  if (!wait_until(*child_, listens)) {
    throw std::runtime_error(scenario.name + " does not start:\n" + said());
  }
  if (means.allocations && allocations().value_or(0) == 0) {
    throw std::runtime_error("allocations are not counted: " + means.allocations->string() +
                             " cannot be preloaded:\n" + said());
  }
  for (std::size_t bus = 0; bus < paths.size(); ++bus) {
    doors_.ports.push_back(port_of(line_name(bus)));
  }
  flood_port_ = load.flood > 0 ? port_of("flood") : std::uint16_t{0};
  handshake_port_ = load.handshakes > 0 ? port_of("handshakes") : std::uint16_t{0};
}

void Subject::start_signer(const Means& means) {
  const auto socket = means.folder / kSigner;
  std::filesystem::remove(socket);  // of the run before
  signer_.emplace(Child::command("'" + means.signer.string() + "' --keys '" +
                                     means.folder.string() + "' --socket '" + socket.string() + "'",
                                 means.folder / "signer.log"));
  if (!wait_until(*signer_, [&] { return std::filesystem::exists(socket); })) {
    throw std::runtime_error(means.signer.string() + " does not start");
  }
}

void Subject::start_relay(const Scenario& scenario, const std::string& path) {
  const Listening listening = listen_somewhere();
  doors_.ports = {listening.port};
  child_.emplace(Child::run([&](int) { run_relay(scenario.plant, path, listening.socket.get()); }));
}

void Subject::start_command(const Scenario& scenario, const Means& means, const std::string& path) {
  // Free now, and most likely still when the command listens there.
  const std::uint16_t port = listen_somewhere().port;
  std::string command = means.commands.at(scenario.program);
  replace_all(command, "{device}", path);
  replace_all(command, "{baud}",
              std::to_string(scenario.plant.paced() ? scenario.plant.baud : 115200));
  replace_all(command, "{port}", std::to_string(port));
  replace_all(command, "{certificate}", (means.folder / "gateway.crt").string());
  replace_all(command, "{key}", (means.folder / "gateway.key").string());
  replace_all(command, "{authorities}", (means.folder / "ca.crt").string());
  child_.emplace(Child::command(command, log_));
  const auto takes_clients = [&] {
    try {
      connect_to(port);
      return true;
    } catch (const std::system_error&) {
      return false;
    }
  };
  if (!wait_until(*child_, takes_clients)) {
    throw std::runtime_error(scenario.name + " does not listen at 127.0.0.1:" +
                             std::to_string(port) + " (" + command + "):\n" + said());
  }
  doors_.ports = {port};
}

std::string Subject::said() const {
  std::ostringstream text;
  text << std::ifstream(log_).rdbuf();
  return std::move(text).str();
}

std::optional<std::uint64_t> Subject::allocations() const {
  std::uint64_t count = 0;
  std::ifstream file(counter_, std::ios::binary);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of a number
  if (!file.read(reinterpret_cast<char*>(&count), sizeof count)) {
    return std::nullopt;
  }
  return count;
}

}  // namespace mbgate::bench
