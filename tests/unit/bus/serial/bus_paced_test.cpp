// SPDX-License-Identifier: Apache-2.0
// Lines that keep the pace of the wire: no byte of an answer can have come before its time, however
// the adapter has delivered it. At 19200 baud 10 bits take 521 us, and 3 % less 505 us.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

constexpr Duration kAnswerOnWire = 3536458ns;  // 7 characters of 10 bits, less 3 %

class BusPaced : public Bus {
 protected:
  void open_on(bus::LineKind kind, bus::Framing framing = bus::Framing::rtu) {
    auto paced = settings();
    paced.line.echo = false;
    paced.line.framing = framing;
    bus_.emplace(paced, std::vector<drive::Device>{});
    bus_->start();
    bus_->handle_opened(now_, kind);
    drain();
    advance(5ms);
  }
};

TEST_F(BusPaced, AnAnswerInOnePieceCannotHaveComeBeforeItsLastByte) {
  for (const auto& [after, is_answer] :
       {std::pair{kAnswerOnWire - 1us, false}, {kAnswerOnWire, true}}) {
    endings_.clear();
    open_on(bus::LineKind::uart);
    submit(job(kRead));
    advance(kEmission + after);
    line(kAnswer);
    EXPECT_EQ(!endings_.empty(), is_answer);
    advance(10s);
  }
}

TEST_F(BusPaced, NorOneInPiecesBeforeTheLastByteOfEach) {
  open_on(bus::LineKind::uart);
  submit(job(kRead));
  advance(kEmission + 1ms);
  line("01 03 02");  // 1.5 ms at least
  advance(10ms);
  line("12 34 B5 33");
  EXPECT_THAT(endings_, IsEmpty());
}

TEST_F(BusPaced, WhereTheLineKeepsNoPaceItMayComeAtOnce) {
  open_on(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(kEmission);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusPaced, ThereItIsTimedByTheFirstByteBehindTheRequest) {
  open_on(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(kEmission - 1ms);
  line("01 03 02 12 34 B5");
  advance(11ms);
  line("33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_GT(*bus_->devices()[1].times.device.lately().percentile(50), 8ms);
}

TEST_F(BusPaced, InAsciiItIsTheSame) {
  const std::string answer = ":0103021234B4\r\n";
  for (const auto& [after, is_answer] : {std::pair{7500us, false}, {7600us, true}}) {  // 7.58 ms
    endings_.clear();
    open_on(bus::LineKind::uart, bus::Framing::ascii);
    submit(job(kRead));
    advance(modbus::RtuTiming(modbus::Baud{19200}, {}).duration_of(17) + after);
    bus_->handle_bytes({reinterpret_cast<const std::uint8_t*>(answer.data()), answer.size()}, now_);
    drain();
    EXPECT_EQ(!endings_.empty(), is_answer);
    advance(10s);
  }
}

}  // namespace
}  // namespace mbgate::test
