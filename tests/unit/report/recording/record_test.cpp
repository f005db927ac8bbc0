// SPDX-License-Identifier: Apache-2.0
// The text of a recording, and that a machine does the same again when it is read.
#include "report/recording/record.hpp"

#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;
using test::unhex;

constexpr Instant kAt{Duration{1234567890123}};

std::string line_of(const Input& input) {
  std::string out;
  append_line(out, input, kAt);
  return out;
}

std::string line_of(const Action& action) {
  std::string out;
  append_line(out, action, test::one_bus());
  return out;
}

// Reads the line and writes it again.
std::string again(const std::string& line) {
  std::vector<std::uint8_t> storage;
  const auto read = parse_line(line, storage);
  if (!read) {
    return read.error();
  }
  std::string out;
  append_line(out, read->input, read->at);
  return out;
}

TEST(Record, EveryInputIsALineThatCanBeReadAgain) {
  const auto bytes = unhex("00 01 AB");
  const ClientInfo info{ListenerId{2}, *routing::ClientAddress::parse("192.0.2.1"),
                        Instant{Duration{12}}};
  ClientInfo of_role = info;
  of_role.role = {routing::ClientRole::Kind::named, "Op 1"};
  ClientInfo of_null_role = info;
  of_null_role.role.kind = routing::ClientRole::Kind::named;
  ClientInfo without_rights = info;
  without_rights.role.kind = routing::ClientRole::Kind::unreadable;
  ClientInfo with_certificate = of_role;
  with_certificate.role.certificate = "PLC 1";
  ClientInfo null_role_with_certificate = of_null_role;
  null_role_with_certificate.role.certificate = "PLC 1";
  const std::vector<std::pair<Input, std::string>> all{
      {ClientConnected{ClientId{7}, info}, "1234567890123 connected 7 2 192.0.2.1 12"},
      {ClientConnected{ClientId{7}, of_role},
       "1234567890123 connected 7 2 192.0.2.1 12 role 4F702031"},
      {ClientConnected{ClientId{7}, of_null_role},
       "1234567890123 connected 7 2 192.0.2.1 12 role "},
      {ClientConnected{ClientId{7}, without_rights},
       "1234567890123 connected 7 2 192.0.2.1 12 no-role"},
      {ClientConnected{ClientId{7}, with_certificate},
       "1234567890123 connected 7 2 192.0.2.1 12 role 4F702031 certificate 504C432031"},
      {ClientConnected{ClientId{7}, null_role_with_certificate},
       "1234567890123 connected 7 2 192.0.2.1 12 role  certificate 504C432031"},
      {ClientBytes{ClientId{7}, bytes, 5}, "1234567890123 read 7 5 0001AB"},
      {ClientBytes{ClientId{7}, {}, 0}, "1234567890123 read 7 0 "},
      {ClientSent{ClientId{7}}, "1234567890123 sent 7"},
      {ClientHalfClosed{ClientId{7}}, "1234567890123 fin 7"},
      {ClientDisconnected{ClientId{7}}, "1234567890123 gone 7"},
      {ClientDisconnected{ClientId{7}, bytes}, "1234567890123 gone 7 0001AB"},
      {LineOpened{BusId{1}}, "1234567890123 opened 1 virtual"},
      {LineBytes{BusId{1}, bytes}, "1234567890123 line 1 0001AB"},
      {LineUnsent{BusId{1}, 8}, "1234567890123 unsent 1 8"},
      {LineLost{BusId{1}}, "1234567890123 lost 1"},
      {LineLost{BusId{1}, bus::Loss::closed}, "1234567890123 closed 1"},
      {DeadlineReached{}, "1234567890123 time"},
      {Stalled{std::chrono::seconds(10)}, "1234567890123 stalled 10000"},
      {ClearCountersAsked{}, "1234567890123 clear"},
      {ShutdownAsked{}, "1234567890123 shutdown"}};
  for (const auto& [input, line] : all) {
    EXPECT_EQ(line_of(input), line + '\n');
    EXPECT_EQ(again(line), line + '\n');
  }
}

TEST(Record, EveryActionIsALine) {
  const ClientId client{7};
  const BusId bus{0};
  EXPECT_EQ(line_of(Send{client, {0x00, 0x01}}), "< send 7 0001\n");
  EXPECT_EQ(line_of(Pause{client}), "< pause 7\n");
  EXPECT_EQ(line_of(Resume{client}), "< resume 7\n");
  EXPECT_EQ(line_of(Close{client}), "< close 7\n");
  EXPECT_EQ(line_of(Open{bus}), "< open 0\n");
  EXPECT_EQ(line_of(Transmit{bus, {0x01, 0xFF}}), "< transmit 0 01FF\n");
  EXPECT_EQ(line_of(Shut{bus}), "< shut 0\n");
  EXPECT_EQ(line_of(Report{BusOpened{bus}}), "< report bus line-a is open\n");
  EXPECT_EQ(line_of(Finished{}), "< finished\n");
}

TEST(Record, SaysWhatIsWrongWithALine) {
  EXPECT_EQ(again(""), "expected an instant in nanoseconds, found \"\"");
  EXPECT_EQ(again("12x time"), "expected an instant in nanoseconds, found \"12x\"");
  EXPECT_EQ(again("12"), "expected an input at the end of the line");
  EXPECT_EQ(again("12 tick"), "expected an input, found \"tick\"");
  EXPECT_EQ(again("12 clear 0"), "expected the end of the line, found \"0\"");
  EXPECT_EQ(again("12 time 1"), "expected the end of the line, found \"1\"");
  EXPECT_EQ(again("12 sent -1"), "expected the number of a client, found \"-1\"");
  EXPECT_EQ(again("12 lost"), "expected the place of a bus at the end of the line");
  EXPECT_EQ(again("12 unsent 0 x"), "expected a number of bytes, found \"x\"");
  EXPECT_EQ(again("12 line 0 0g"), "expected hexadecimal bytes, found \"0g\"");
  EXPECT_EQ(again("12 line 0 012"), "expected hexadecimal bytes, found \"012\"");
  EXPECT_EQ(again("12 connected 1 0 here 0"), "expected an address, found \"here\"");
  EXPECT_EQ(again("12 connected 1 0 192.0.2.1 0 boss"), "expected role or no-role, found \"boss\"");
  EXPECT_EQ(again("12 connected 1 0 192.0.2.1 0 role 41 boss"),
            "expected certificate, found \"boss\"");
  EXPECT_EQ(again("12 connected 1 0 192.0.2.1 0 role 4"),
            "expected hexadecimal bytes, found \"4\"");
  EXPECT_EQ(again("12 read 1 0 " + std::string(4098, '0')),
            "expected at most 2048 bytes, found \"2049 bytes\"");
}

TEST(Record, TheHeadCarriesTheWholeConfiguration) {
  RecordingHead head;
  head.version = "1.2.3";
  head.profiles = "/srv/my profiles";
  head.config = {{"/etc/mbgate/mbgate.toml", "[[bus]]\n\n  name = \"a\"\n"},
                 {"/etc/mbgate/conf.d/10 empty.toml", ""},
                 {"/etc/mbgate/conf.d/20.toml", "config = 1\nno newline"}};
  std::string text = head_lines(head);
  append_start(text, kAt);
  EXPECT_EQ(text,
            "mbgate recording 1\nversion 1.2.3\nprofiles /srv/my profiles\n"
            "config /etc/mbgate/mbgate.toml\n| [[bus]]\n| \n|   name = \"a\"\n"
            "config /etc/mbgate/conf.d/10 empty.toml\n"
            "config /etc/mbgate/conf.d/20.toml\n| config = 1\n| no newline\n"
            "1234567890123 start\n");
  HeadReader reader;
  std::size_t begin = 0;
  bool complete = false;
  while (begin < text.size()) {
    const std::size_t end = text.find('\n', begin);
    ASSERT_FALSE(complete);
    const auto read = reader.read(std::string_view(text).substr(begin, end - begin));
    ASSERT_TRUE(read);
    complete = *read;
    begin = end + 1;
  }
  EXPECT_TRUE(complete);
  EXPECT_EQ(reader.head().version, head.version);
  EXPECT_EQ(reader.head().profiles, head.profiles);
  ASSERT_EQ(reader.head().config.size(), 3U);
  EXPECT_EQ(reader.head().config[0].path, head.config[0].path);
  EXPECT_EQ(reader.head().config[0].text, head.config[0].text);
  EXPECT_EQ(reader.head().config[1].path, head.config[1].path);
  EXPECT_EQ(reader.head().config[1].text, "");
  EXPECT_EQ(reader.head().config[2].text, "config = 1\nno newline\n");
  EXPECT_EQ(reader.head().start, kAt);
}

TEST(Record, SaysWhatIsWrongWithAHead) {
  EXPECT_EQ(HeadReader().read("[[bus]]").error(),
            "expected \"mbgate recording 1\": this is not a recording");
  HeadReader reader;
  ASSERT_TRUE(reader.read("mbgate recording 1"));
  EXPECT_EQ(reader.read("name = 1").error(),
            "expected a line of the configuration or the start, found \"name = 1\"");
  EXPECT_EQ(reader.read("| name = 1").error(),
            "expected a line of the configuration or the start, found \"| name = 1\"");
  EXPECT_EQ(reader.read("5 start").error(), "expected the configuration before the start");
  EXPECT_EQ(reader.read("soon start").error(),
            "expected an instant in nanoseconds before \"start\"");
}

// A client asks, the device answers, the client is told: by inputs as values, the second time as
// they were read from their lines.
TEST(Record, AMachineDoesTheSameAgain) {
  const auto request = unhex(test::read_request(1));
  const auto answer = unhex("01 03 02 00 2A 39 9B");
  const ClientInfo info{ListenerId{0}, *routing::ClientAddress::parse("192.0.2.1")};
  const std::vector<std::pair<Duration, Input>> inputs{
      {std::chrono::milliseconds(0), LineOpened{BusId{0}}},
      {std::chrono::milliseconds(9), ClientConnected{ClientId{0}, info}},
      {std::chrono::milliseconds(10), ClientBytes{ClientId{0}, request}},
      {std::chrono::milliseconds(10), LineLooked{BusId{0}}},
      {std::chrono::milliseconds(10), DeadlineReached{}},
      {std::chrono::milliseconds(40), LineBytes{BusId{0}, answer}},
      {std::chrono::milliseconds(40), ClientSent{ClientId{0}}},
      {std::chrono::milliseconds(50), ShutdownAsked{}}};
  std::string recorded;
  std::string replayed;
  std::vector<std::uint8_t> storage;
  test::GatewayHarness first(test::one_bus(), kAt);
  test::GatewayHarness second(test::one_bus(), kAt);
  for (const auto& [after, input] : inputs) {
    std::string line;
    append_line(line, input, kAt + after);
    recorded += line;
    first.handle(input, kAt + after);
    first.drain([&](const Action& action) { append_line(recorded, action, first.settings()); });
    line.pop_back();
    const auto read = parse_line(line, storage);
    ASSERT_TRUE(read);
    second.handle(read->input, read->at);
    append_line(replayed, read->input, read->at);
    second.drain([&](const Action& action) { append_line(replayed, action, second.settings()); });
  }
  EXPECT_EQ(recorded, replayed);
  EXPECT_THAT(recorded, testing::HasSubstr("< send 0 000100000005010302002A"));
}

}  // namespace
}  // namespace mbgate::report
