// SPDX-License-Identifier: Apache-2.0
#include "app/who/who_options.hpp"

#include <gtest/gtest.h>

namespace mbgate::app {
namespace {

gateway::Settings two_listeners() {
  gateway::Settings settings;
  settings.listeners.resize(2);
  settings.listeners[0].name = "plant";
  settings.listeners[0].read_only = {*routing::Network::parse("10.0.0.0/8")};
  settings.listeners[1].name = "service";
  settings.buses.resize(1);
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.first_address = 1;
  route.last_unit = 20;
  route.buses = {drive::BusId{0}};
  return settings;
}

const config::KeyPlaces kPlaces{{{"allow", 0}, "x.toml:3"},
                                {{"read_only", 0}, "x.toml:4"},
                                {{"access", 0}, "x.toml:10"},
                                {{"functions", 0}, "x.toml:11"},
                                {{"windows", 0}, "x.toml:12"}};

std::string answer(const WhoOptions& options) {
  const auto answers = answer_who(two_listeners(), kPlaces, options);
  return answers ? answers->text : answers.error();
}

TEST(WhoOptions, AreAskedOfEachListener) {
  WhoOptions options{.client = "10.0.0.5", .unit = 11, .write = {"holding", "0x7C"}};
  EXPECT_EQ(answer(options),
            "10.0.0.5 on plant: write holding 0x7C of unit 11 (function 6): denied by read_only of "
            "listener plant (x.toml:4): exception 01\n"
            "10.0.0.5 on service: write holding 0x7C of unit 11 (function 6): permitted: there are "
            "no rules\n");
  EXPECT_TRUE(answer_who(two_listeners(), kPlaces, options)->any_permitted);
  options.listener = "plant";
  options.role = "operator";  // nobody has one without TLS
  options.count = 2;
  EXPECT_EQ(answer(options),
            "10.0.0.5 on plant: write holding 0x7C and 1 more of unit 11 (function 16): denied by "
            "read_only of listener plant (x.toml:4): exception 01\n");
  EXPECT_FALSE(answer_who(two_listeners(), kPlaces, options)->any_permitted);
}

TEST(WhoOptions, AreAnsweredWithThePlaceOfTheKeyThatDenies) {
  WhoOptions options{
      .client = "11.0.0.5", .listener = "plant", .unit = 11, .write = {"holding", "124"}};
  gateway::Settings settings = two_listeners();
  const auto denied_by = [&] {
    const std::string text = answer_who(settings, kPlaces, options)->text;
    return text.substr(text.find("): ") + 3);
  };
  auto& route = settings.routes[0];
  route.windows = {{modbus::Table::holding_registers, 0, 4, modbus::Table::holding_registers, 0}};
  EXPECT_EQ(
      denied_by(),
      "denied by the windows (registers) of the route of unit 11 (x.toml:12): exception 02\n");
  route.functions.allowed.reset(6);
  EXPECT_EQ(denied_by(), "denied by functions of the route of unit 11 (x.toml:11): exception 01\n");
  route.access = routing::Access::read_only;
  EXPECT_EQ(denied_by(), "denied by access of the route of unit 11 (x.toml:10): exception 01\n");
  settings.listeners[0].allow = {*routing::Network::parse("10.0.0.0/8")};
  EXPECT_EQ(denied_by(),
            "refused by allow of listener plant (x.toml:3): the connection is closed at once\n");
  settings.listeners[1].read_only = {*routing::Network::parse("11.0.0.0/8")};
  options.listener = "service";  // of whose keys nothing is known
  EXPECT_EQ(denied_by(), "denied by read_only of listener service: exception 01\n");
}

TEST(WhoOptions, HaveARoleWhereThereIsTls) {
  gateway::Settings settings = two_listeners();
  settings.listeners[1].tls = 0;
  auto& rule = settings.rules.emplace_back();
  rule.place = "mbgate.toml:12";
  rule.roles = {"operator"};
  WhoOptions options{
      .client = "10.0.0.5", .listener = "service", .unit = 11, .write = {"holding", "0x7C"}};
  EXPECT_EQ(answer_who(settings, kPlaces, options)->text,
            "10.0.0.5 with the NULL role on service: write holding 0x7C of unit 11 (function 6): "
            "denied by the access rules: no rule permits it: exception 01\n");
  options.role = "operator";
  EXPECT_EQ(answer_who(settings, kPlaces, options)->text,
            "10.0.0.5 as role \"operator\" on service: write holding 0x7C of unit 11 (function 6): "
            "permitted by rule mbgate.toml:12\n");
}

TEST(WhoOptions, ChooseTheFunctionByTableAndCount) {
  WhoOptions options{.client = "::1", .listener = "plant", .unit = 1};
  const auto function = [&] {
    const std::string text = answer(options);
    const auto begin = text.find("(function ");
    return begin == std::string::npos ? text : text.substr(begin, text.find(')') + 1 - begin);
  };
  options.read = {"coils", "0"};
  EXPECT_EQ(function(), "(function 1)");
  options.read = {"discrete", "0"};
  EXPECT_EQ(function(), "(function 2)");
  options.read = {"holding", "0"};
  EXPECT_EQ(function(), "(function 3)");
  options.read = {"input", "0"};
  EXPECT_EQ(function(), "(function 4)");
  options.read.clear();
  options.write = {"coils", "65535"};
  options.value = 1;
  EXPECT_EQ(function(), "(function 5)");
  options.write = {"coils", "0"};
  options.count = 9;
  EXPECT_EQ(function(), "(function 15)");
}

TEST(WhoOptions, AreRefusedWithWhatWouldBeRight) {
  const std::string usage =
      "expected --read or --write, each with a table and an address, such as --write holding 124";
  const auto with = [](auto change) {
    WhoOptions options{.client = "10.0.0.5", .unit = 1, .write = {"holding", "1"}};
    change(options);
    return answer(options);
  };
  EXPECT_EQ(with([](auto& it) { it.client = "panel"; }),
            "--who: expected an IPv4 or IPv6 address, such as 192.168.10.5");
  EXPECT_EQ(with([](auto& it) { it.unit = 256; }), "--unit: expected 0 to 255");
  EXPECT_EQ(with([](auto& it) { it.write.clear(); }), usage);
  EXPECT_EQ(with([](auto& it) { it.read = {"holding", "1"}; }), usage);
  EXPECT_EQ(with([](auto& it) { it.write = {"register", "1"}; }), usage);
  EXPECT_EQ(with([](auto& it) { it.write = {"holding", "65536"}; }), usage);
  EXPECT_EQ(with([](auto& it) {
              it.write = {"input", "1"};
            }),
            "--write: expected a table that can be written, coils or holding");
  EXPECT_EQ(with([](auto& it) { it.count = 0; }),
            "--count: expected 1 or more, and no address beyond 65535");
  EXPECT_EQ(with([](auto& it) { it.count = 124; }), "--count: expected at most 123");
  EXPECT_EQ(with([](auto& it) { it.value = 65536; }), "--value: expected 0 to 65535");
  EXPECT_EQ(with([](auto& it) { it.listener = "plnt"; }),
            "--listener: no [[listen]] is named \"plnt\"");
}

}  // namespace
}  // namespace mbgate::app
