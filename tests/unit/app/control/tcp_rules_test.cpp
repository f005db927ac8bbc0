// SPDX-License-Identifier: Apache-2.0
#include "app/control/tcp_rules.hpp"

#include <gtest/gtest.h>

#include "app/control/control_answers.hpp"

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;

http::request_header<> request(http::verb method, const std::string& host) {
  http::request_header<> asked;
  asked.method(method);
  asked.target("/api/v1/status");
  asked.version(11);
  asked.set(http::field::host, host);
  return asked;
}

TEST(PathOf, IsTheSameInEitherFormOfATarget) {
  auto asked = request(http::verb::get, "gateway");
  for (const char* target : {"/healthz", "/healthz?a", "http://gateway:8080/healthz?a=/"}) {
    asked.target(target);
    EXPECT_EQ(path_of(asked), "/healthz");
  }
  asked.target("http://gateway");
  EXPECT_EQ(path_of(asked), "");
}

TEST(TcpRules, TakeAddressesAndLocalhostForThisMachine) {
  for (const char* host : {"127.0.0.1", "127.0.0.1:8080", "192.168.10.2:8080", "[::1]",
                           "[::1]:8080", "localhost", "LocalHost:8080"}) {
    EXPECT_TRUE(is_own_host(host, {})) << host;
  }
}

TEST(TcpRules, TakeNoOtherNameForThisMachineThatIsNotGiven) {
  for (const char* host :
       {"", ":", "[", "[]", "evil.example", "evil.example:8080", "127.0.0.1.evil.example",
        "localhost.evil.example", "[evil.example]", "gateway"}) {
    EXPECT_FALSE(is_own_host(host, {"gateway.plant"})) << host;
  }
  EXPECT_TRUE(is_own_host("gateway.plant", {"panel", "gateway.plant"}));
  EXPECT_TRUE(is_own_host("Gateway.Plant:8080", {"panel", "gateway.plant"}));
}

TEST(TcpRules, LetReadWhoMeansThisMachineOrNamesNone) {
  EXPECT_FALSE(refused_over_tcp(request(http::verb::get, "127.0.0.1:8080"), {}));
  auto nameless = request(http::verb::get, "");
  nameless.erase(http::field::host);
  nameless.version(10);
  EXPECT_FALSE(refused_over_tcp(nameless, {}));
}

TEST(TcpRules, RefuseWhatIsMeantForAnotherName) {
  const auto refusal = refused_over_tcp(request(http::verb::get, "evil.example\xFF:80"), {});
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->status, http::status::misdirected_request);
  EXPECT_EQ(refusal->why,
            "\"evil.example\xEF\xBF\xBD:80\" is not a name of this machine: use its address, or "
            "add the name to [http] hosts");
}

TEST(TcpRules, RefuseWhatWouldChangeSomething) {
  const auto refusal = refused_over_tcp(request(http::verb::post, "127.0.0.1"), {});
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->status, http::status::forbidden);
  EXPECT_EQ(refusal->why,
            "expected the Unix socket ([http] socket): nothing can be changed over TCP");
}

TEST(TcpRules, TakeAPageForOursWhoseOriginIsTheHost) {
  EXPECT_TRUE(is_same_origin("http://192.168.10.2:8080", "192.168.10.2:8080"));
  EXPECT_TRUE(is_same_origin("https://gateway.plant", "Gateway.Plant"));
  EXPECT_TRUE(is_same_origin("http://[::1]:8080", "[::1]:8080"));
  for (const char* origin : {"", "null", "http://", "http://evil.example", "http://192.168.10.2",
                             "http://192.168.10.2:80", "192.168.10.2:8080",
                             "http://192.168.10.2:8080.evil.example", "file://192.168.10.2:8080"}) {
    EXPECT_FALSE(is_same_origin(origin, "192.168.10.2:8080")) << origin;
  }
}

TEST(TcpRules, RefuseAPageFromElsewhere) {
  auto asked = request(http::verb::get, "127.0.0.1:8080");
  asked.set(http::field::origin, "http://127.0.0.1:8080");
  EXPECT_FALSE(refused_over_tcp(asked, {}));
  asked.set(http::field::origin, "http://evil.example");
  const auto refusal = refused_over_tcp(asked, {});
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->status, http::status::forbidden);
  EXPECT_EQ(refusal->why,
            "the request comes from a page of another origin, \"http://evil.example\" (Origin)");
  asked.erase(http::field::host);
  EXPECT_TRUE(refused_over_tcp(asked, {}));
  asked.set(http::field::origin, "http://");
  EXPECT_TRUE(refused_over_tcp(asked, {})) << "no name is not the name that is missing";
}

std::optional<http::status> status_of(const std::optional<Refusal>& refusal) {
  return refusal ? std::optional(refusal->status) : std::nullopt;
}

TEST(TcpRules, RefuseARequestThatDoesNotNameOneHost) {
  auto twice = request(http::verb::get, "localhost");
  twice.insert(http::field::host, "localhost");
  EXPECT_EQ(status_of(refused_over_tcp(twice, {})), http::status::bad_request);
  EXPECT_EQ(status_of(refused_over_socket(twice)), http::status::bad_request);
  auto nameless = request(http::verb::get, "");
  nameless.erase(http::field::host);
  EXPECT_EQ(status_of(refused_over_tcp(nameless, {})), http::status::bad_request);
  EXPECT_EQ(status_of(refused_over_socket(nameless)), http::status::bad_request);
  nameless.version(10);
  EXPECT_FALSE(refused_over_socket(nameless));
}

TEST(TcpRules, RefuseWhatABrowserAsksForAnotherPage) {
  for (const char* site : {"cross-site", "same-site", "of-tomorrow", ""}) {
    auto asked = request(http::verb::get, "localhost");
    asked.set("Sec-Fetch-Site", site);
    EXPECT_EQ(status_of(refused_over_tcp(asked, {})), http::status::forbidden) << site;
    EXPECT_EQ(status_of(refused_over_socket(asked)), http::status::forbidden) << site;
  }
  for (const char* site : {"same-origin", "none"}) {
    auto asked = request(http::verb::get, "localhost");
    asked.set("Sec-Fetch-Site", site);
    EXPECT_FALSE(refused_over_tcp(asked, {})) << site;
  }
}

TEST(TcpRules, LetALinkElsewhereLeadToThePageAndNothingElse) {
  auto link = request(http::verb::get, "localhost");
  link.set("Sec-Fetch-Site", "cross-site");
  link.set("Sec-Fetch-Mode", "navigate");
  link.set("Sec-Fetch-Dest", "document");
  EXPECT_TRUE(refused_over_tcp(link, {}));
  link.target("/");
  EXPECT_FALSE(refused_over_tcp(link, {}));
  link.set("Sec-Fetch-Dest", "iframe");
  EXPECT_TRUE(refused_over_tcp(link, {}));
}

TEST(TcpRules, GiveABrowserAStreamOnlyAsOne) {
  auto asked = request(http::verb::get, "localhost");
  asked.target("/api/v1/events");
  asked.set(http::field::accept, "*/*");
  EXPECT_FALSE(refused_over_tcp(asked, {})) << "curl";
  asked.set(http::field::user_agent, "Mozilla/5.0 (X11)");
  EXPECT_EQ(status_of(refused_over_tcp(asked, {})), http::status::not_acceptable);
  asked.set(http::field::accept, "text/event-stream");
  EXPECT_FALSE(refused_over_tcp(asked, {}));
}

TEST(TcpRules, RefuseAnyOriginOnTheUnixSocket) {
  auto asked = request(http::verb::get, "any name");
  EXPECT_FALSE(refused_over_socket(asked));
  asked.set(http::field::origin, "http://any name");
  const auto refusal = refused_over_socket(asked);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->status, http::status::forbidden);
}

}  // namespace
}  // namespace mbgate::app
