// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/doctor_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/profile_options.hpp"
#include "ctl/options/server_options.hpp"
#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kMostRequests = 10'000;

}  // namespace

DoctorOptions::DoctorOptions(CLI::App& app)
    : doctor_(app.add_subcommand(
          "doctor",
          "Say what is wrong with a serial line, step by step, and how it is known: the port, the "
          "permission, who holds it, the adapter's delay, noise, an echo, the answers of the "
          "devices, two of them at one address. No gateway may hold the port. Only reads are "
          "sent, and none where another client is heard.")) {
  add_line();
  add_effort();
  doctor_->add_flag("--json", words_.json, "for programs: one JSON object");
}

void DoctorOptions::add_line() {
  auto* device = doctor_
                     ->add_option("--device", device_,
                                  "examine this serial port, which no configuration describes")
                     ->type_name("PATH")
                     ->check([](const std::string& path) {
                       return path.empty() ? "expected the path of a serial port" : std::string();
                     });
  doctor_->add_option("--baud", baud_, "with --device: its rate")
      ->needs(device)
      ->capture_default_str();
  doctor_->add_option("--parity", parity_, "with --device: even, none or odd")
      ->needs(device)
      ->capture_default_str();
  doctor_->add_option("--stop-bits", stop_bits_, "with --device: 1, or 2 where there is no parity")
      ->needs(device)
      ->capture_default_str();
  doctor_
      ->add_option("--timeout", timeout_,
                   "with --device: the first byte of an answer that comes later is late")
      ->needs(device)
      ->capture_default_str();
  doctor_
      ->add_option("--bus", words_.bus, "examine this bus of the configuration, not the only one")
      ->type_name("NAME")
      ->excludes(device);
  doctor_->add_option("--config", words_.config, "the configuration file, with --bus")
      ->excludes(device)
      ->capture_default_str();
  add_profile_folder(*doctor_, words_.folder);
}

void DoctorOptions::add_effort() {
  doctor_->add_option("--address", units_,
                      "whom to ask: 5 or 1-8,17; none: the devices of the configuration");
  doctor_
      ->add_option("--register", words_.holding_register,
                   "the holding register that is read, its protocol address")
      ->capture_default_str();
  doctor_->add_option("--requests", words_.requests, "how many reads each device gets")
      ->check(CLI::Range(1U, kMostRequests))
      ->capture_default_str();
  doctor_->add_option("--listen", listen_, "how long to listen before anything is sent")
      ->capture_default_str();
}

bool DoctorOptions::given() const { return doctor_->parsed(); }

Result<ExaminedPort, std::string> DoctorOptions::port() const {
  const auto modes = parse_modes(baud_, parity_, stop_bits_);
  if (!modes) {
    // Said in full, because a text alone could be a port too, its path.
    return {boost::system::in_place_error, modes.error()};
  }
  if (modes->size() != 1) {
    return {boost::system::in_place_error, "one rate, one parity, and 1 or 2 stop bits: no lists"};
  }
  const auto timeout = parse_time(timeout_, std::chrono::milliseconds(1));
  if (!timeout) {
    return {boost::system::in_place_error, timeout.error()};
  }
  return ExaminedPort{device_, modes->front(), *timeout};
}

Result<Command, std::string> DoctorOptions::command() const {
  DoctorCommand doctor = words_;
  if (!device_.empty()) {
    const auto examined = port();
    if (!examined) {
      return examined.error();
    }
    doctor.port = *examined;
  }
  if (!units_.empty()) {
    auto units = parse_units(units_);
    if (!units) {
      return units.error();
    }
    doctor.units = *std::move(units);
  }
  const auto listen = parse_time(listen_, std::chrono::milliseconds(1));
  if (!listen) {
    return listen.error();
  }
  doctor.listen = *listen;
  return Command(doctor);
}

}  // namespace mbgate::ctl
