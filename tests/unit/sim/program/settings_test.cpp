// SPDX-License-Identifier: Apache-2.0
#include "sim/program/settings.hpp"

#include <gtest/gtest.h>

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

std::string errors_of(std::string_view text) {
  const auto loaded = sim::load_settings({"sim.toml", std::string(text)});
  EXPECT_FALSE(loaded.settings);
  return config::render(loaded.diagnostics);
}

TEST(SimulatorSettings, ReadsTheDemo) {
  const auto loaded =
      sim::load_settings(config::read_text_file(MBGATE_SOURCE_DIR "/conf/demo-sim.toml"));
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  const auto& buses = loaded.settings->buses;
  ASSERT_EQ(buses.size(), 2U);
  EXPECT_EQ(buses[0].name, "line-a");
  EXPECT_EQ(buses[0].link, "line-a");
  EXPECT_EQ(buses[0].wire.baud, modbus::Baud{115200});
  EXPECT_EQ(buses[0].wire.format.bits(), 10U);
  EXPECT_EQ(buses[1].wire.baud, modbus::Baud{9600});
  EXPECT_EQ(buses[1].wire.format.bits(), 11U);
  ASSERT_EQ(buses[0].devices.size(), 2U);
  EXPECT_EQ(buses[0].devices[0].word_order, drive::WordOrder::big);
  EXPECT_EQ(buses[0].devices[1].model, sim::ModelKind::stepper);
  ASSERT_EQ(buses[1].devices.size(), 2U);
  EXPECT_EQ(buses[1].devices[0].address, 17);
  EXPECT_EQ(buses[1].devices[0].response_wait, 20ms);
  EXPECT_EQ(buses[1].devices[1].word_order, drive::WordOrder::little);
}

TEST(SimulatorSettings, ReadsEveryKey) {
  const auto loaded = sim::load_settings({"sim.toml", R"(
reopen_after = "250ms"
[[bus]]
name = "a"
link = "/tmp/a"
baud = 250000
parity = "odd"
data_bits = 8
stop_bits = 2
adapter_latency = "16ms"
gap = "0ms"
echo = true
echo_delay = "8ms"
paced = false
[[device]]
name = "x"
bus = "a"
address = 5
model = "moons"
word_order = "little"
series = "m3"
response_wait = "3ms"
processing = "2ms"
faults = { silent = true, answer_after = "400ms", bad_crc = true, wrong_unit = true, wrong_function = true, exception_every = 5 }
)"});
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->reopen_after, 250ms);
  const auto& wire = loaded.settings->buses[0].wire;
  EXPECT_EQ(wire.baud, modbus::Baud{250000});
  EXPECT_EQ(wire.format, (modbus::CharacterFormat{8, modbus::Parity::odd, 2}));
  EXPECT_EQ(wire.adapter_latency, 16ms);
  EXPECT_EQ(wire.gap, 0ms);
  EXPECT_TRUE(wire.echo);
  EXPECT_EQ(wire.echo_delay, 8ms);
  EXPECT_FALSE(wire.paced);
  EXPECT_EQ(wire.clocking, sim::Clocking::real_time);
  const auto& device = loaded.settings->buses[0].devices[0];
  EXPECT_EQ(device.series, sim::MoonsSeries::m3);
  EXPECT_EQ(device.processing, 2ms);
  EXPECT_TRUE(device.faults.silent && device.faults.bad_crc && device.faults.wrong_unit &&
              device.faults.wrong_function);
  EXPECT_EQ(device.faults.answer_after, 400ms);
  EXPECT_EQ(device.faults.exception_every, 5U);
}

TEST(SimulatorSettings, ReportsEverythingAtOnce) {
  EXPECT_EQ(errors_of(R"([[bus]]
name = "a"
baud = 0
[[device]]
name = "x"
bus = "b"
address = 248
model = "steper"
[[device]]
name = "x"
bus = "a"
address = 1
model = "aic"
word_order = "big"
response_wait = "1.5ms"
)"),
            R"(sim.toml:1:1: error: [[bus]]: the key 'link' is missing
[[bus]]
^
sim.toml:3:8: error: baud: expected an integer from 1 to 4294967295, found 0
baud = 0
       ^
sim.toml:6:7: error: bus: no [[bus]] is named "b"
bus = "b"
      ^
sim.toml:7:11: error: address: expected an integer from 1 to 247, found 248
address = 248
          ^
sim.toml:8:9: error: model: expected "moons", "stepper", "aic" or "fda6000", found "steper"; did you mean 'stepper'?
model = "steper"
        ^
sim.toml:10:8: error: name: "x" is already used at sim.toml:5:8
name = "x"
       ^
sim.toml:14:14: error: word_order: belongs to a "moons" drive
word_order = "big"
             ^
sim.toml:15:17: error: response_wait: an AiC counts its waiting time in whole milliseconds
response_wait = "1.5ms"
                ^
)");
}

TEST(SimulatorSettings, RefusesADelayOfNoEcho) {
  EXPECT_EQ(errors_of("[[bus]]\nname = \"a\"\nlink = \"a\"\necho_delay = \"8ms\"\n"),
            "sim.toml:4:14: error: echo_delay: belongs to a bus with echo = true\n"
            "echo_delay = \"8ms\"\n"
            "             ^\n");
}

TEST(SimulatorSettings, RefusesToSimulateNothing) {
  EXPECT_EQ(errors_of(""), "sim.toml: error: there is no [[bus]]: nothing to simulate\n");
}

TEST(SimulatorSettings, RefusesWhatIsTakenTwice) {
  EXPECT_EQ(errors_of(R"([[bus]]
name = "a"
link = "l"
[[bus]]
name = "a"
link = "l"
[[device]]
name = "x"
bus = "a"
address = 1
model = "stepper"
[[device]]
name = "y"
bus = "a"
address = 1
model = "stepper"
)"),
            R"(sim.toml:5:8: error: name: "a" is already used at sim.toml:2:8
name = "a"
       ^
sim.toml:6:8: error: link: "l" is already used
link = "l"
       ^
sim.toml:15:11: error: address: 1 is already used on bus "a"
address = 1
          ^
)");
}

TEST(SimulatorSettings, ReadsAsciiBuses) {
  const auto loaded = sim::load_settings({"sim.toml", R"([[bus]]
name = "a"
link = "a"
mode = "ascii"
[[bus]]
name = "b"
link = "b"
mode = "ascii"
data_bits = 8
)"});
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->buses[0].mode, sim::BusMode::ascii);
  EXPECT_EQ(loaded.settings->buses[0].wire.framing, sim::Framing::ascii);
  EXPECT_EQ(loaded.settings->buses[0].wire.format.data_bits, 7U);
  EXPECT_EQ(loaded.settings->buses[1].wire.format.data_bits, 8U);
}

TEST(SimulatorSettings, RefusesWhatDoesNotFitTheFraming) {
  EXPECT_EQ(errors_of(R"([[bus]]
name = "a"
link = "a"
data_bits = 7
[[bus]]
name = "b"
link = "b"
mode = "ascii"
gap = "1ms"
)"),
            R"(sim.toml:4:13: error: data_bits: an RTU bus has 8
data_bits = 7
            ^
sim.toml:9:7: error: gap: an ASCII bus needs no silence between frames
gap = "1ms"
      ^
)");
}

TEST(SimulatorSettings, ReadsBusesThatListen) {
  const auto loaded = sim::load_settings({"sim.toml", R"([[bus]]
name = "cell"
mode = "tcp"
[[bus]]
name = "far"
listen = "0.0.0.0:4001"
baud = 9600
[[device]]
name = "x"
bus = "cell"
model = "moons"
[[device]]
name = "y"
bus = "cell"
address = 0
model = "moons"
)"});
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  const auto& buses = loaded.settings->buses;
  EXPECT_EQ(buses[0].mode, sim::BusMode::tcp);
  EXPECT_EQ(buses[0].listen, (sim::ListenAddress{"127.0.0.1", 0}));
  EXPECT_EQ(buses[0].devices[0].address, 255);
  EXPECT_EQ(buses[0].devices[1].address, 0);
  EXPECT_EQ(buses[1].mode, sim::BusMode::rtu);
  EXPECT_EQ(buses[1].listen, (sim::ListenAddress{"0.0.0.0", 4001}));
}

TEST(SimulatorSettings, RefusesWhatABusThatListensCannotHave) {
  EXPECT_EQ(errors_of(R"([[bus]]
name = "a"
mode = "tcp"
link = "a"
baud = 9600
[[bus]]
name = "b"
listen = "localhost:1"
[[device]]
name = "x"
bus = "a"
address = 256
model = "moons"
faults = { bad_crc = true }
[[device]]
name = "y"
bus = "a"
model = "moons"
)"),
            R"(sim.toml:4:8: error: link: a bus that listens has no link
link = "a"
       ^
sim.toml:5:8: error: baud: a "tcp" bus is not a serial line
baud = 9600
       ^
sim.toml:8:10: error: listen: expected an IPv4 address and a port, such as "127.0.0.1:0", found "localhost:1"
listen = "localhost:1"
         ^
sim.toml:12:11: error: address: expected an integer from 0 to 255, found 256
address = 256
          ^
sim.toml:14:10: error: faults: the frames of a "tcp" bus have no CRC
faults = { bad_crc = true }
         ^
sim.toml:15:1: error: address: 255 is already used on bus "a"
[[device]]
^
)");
}

TEST(SimulatorSettings, KnowsWhatIsAnAddressToListenAt) {
  for (const auto* const wrong : {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536",
                                  "127.0.0.1:1x", "127.0.0:1", "::1:502"}) {
    EXPECT_FALSE(sim::ListenAddress::parse(wrong)) << wrong;
  }
  EXPECT_EQ(sim::ListenAddress::parse("127.0.0.1:65535")->text(), "127.0.0.1:65535");
}

}  // namespace
}  // namespace mbgate::test
