// SPDX-License-Identifier: Apache-2.0
#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

std::string name(int bus) { return "\"line-" + std::to_string(bus) + "\""; }

std::filesystem::path simulator_config(const TemporaryFolder& folder, const PlantOptions& options) {
  std::string text = options.simulator + "\n";
  for (int bus = 0; bus < 2; ++bus) {
    text += "[[bus]]\nname = " + name(bus) + "\nlink = " + name(bus) + "\nparity = \"none\"\n" +
            options.simulated_bus + "\n";
    text += options.paced ? "baud = 115200\n" : "baud = 4000000\npaced = false\n";
  }
  for (int bus = 0; bus < 2; ++bus) {
    for (int address = 1; address <= 2; ++address) {
      text += "[[device]]\nname = \"drive-" + std::to_string(bus) + std::to_string(address) +
              "\"\nbus = " + name(bus) + "\naddress = " + std::to_string(address) +
              "\nmodel = \"moons\"\n" + options.device + "\n";
    }
  }
  return folder.write("sim.toml", text);
}

std::filesystem::path gateway_config(const TemporaryFolder& folder, const PlantOptions& options) {
  std::string text;
  for (int bus = 0; bus < 2; ++bus) {
    text += "[[listen]]\nname = " + name(bus) + "\nport = 0\nbus = " + name(bus) + "\n" +
            options.listener + "\n";
    text += "[[bus]]\nname = " + name(bus) + "\ndevice = " + name(bus) +
            "\nparity = \"none\"\nlisten_first = \"0ms\"\nresponse_timeout = \"" +
            options.response_timeout + "\"\n";
    text += options.paced ? "baud = " + std::to_string(options.baud) + "\n"
                          : "baud = 4000000\nframe_gap = \"0ms\"\n";
    text += options.bus.find("echo") == std::string::npos ? "echo = false\n" : "";
    text += options.bus + "\n";
  }
  return folder.write("mbgate.toml", text);
}

std::vector<std::string> gateway_arguments(const TemporaryFolder& folder,
                                           const PlantOptions& options) {
  std::vector<std::string> arguments{"--config", gateway_config(folder, options).string()};
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  return arguments;
}

}  // namespace

Plant::Plant(const PlantOptions& options)
    : simulator("mbgate-sim", {simulator_config(folder, options).string()}, {folder.path(), {}}),
      gateway((simulator.wait_for_line("ready"), "mbgated"), gateway_arguments(folder, options),
              {folder.path(), {}}) {}

ByteString request(unsigned transaction, unsigned unit, std::string_view pdu) {
  const ByteString body = bytes_of(pdu);
  ByteString adu{static_cast<std::uint8_t>(transaction >> 8U),
                 static_cast<std::uint8_t>(transaction & 0xFFU),
                 0,
                 0,
                 0,
                 static_cast<std::uint8_t>(body.size() + 1),
                 static_cast<std::uint8_t>(unit)};
  adu.insert(adu.end(), body.begin(), body.end());
  return adu;
}

}  // namespace mbgate::test
