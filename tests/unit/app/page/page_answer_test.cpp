// SPDX-License-Identifier: Apache-2.0
#include "app/page/page_answer.hpp"

#include <gmock/gmock.h>

#include <boost/beast/http/status.hpp>
#include <string>

namespace mbgate::app {
namespace {

namespace http = boost::beast::http;
using testing::HasSubstr;

http::request<http::string_body> asked_for(http::verb method, const std::string& path) {
  constexpr unsigned kVersion = 11;
  return {method, path, kVersion};
}

auto answer_to(http::verb method, const std::string& path) {
  return page_answer(asked_for(method, path), path);
}

TEST(PageAnswer, IsThePageAtTheRoot) {
  const auto answer = answer_to(http::verb::get, "/");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result(), http::status::ok);
  EXPECT_EQ((*answer)[http::field::content_type], "text/html; charset=utf-8");
  EXPECT_THAT(answer->body(), HasSubstr("<!doctype html>"));
  EXPECT_EQ((*answer)[http::field::content_length], std::to_string(answer->body().size()));
}

TEST(PageAnswer, LetsABrowserTakeNothingFromElsewhere) {
  for (const PageFile& file : page_files()) {
    const auto answer = answer_to(http::verb::get, "/page/" + std::string(file.name));
    ASSERT_TRUE(answer) << file.name;
    EXPECT_EQ((*answer)["Content-Security-Policy"],
              "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
              "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    EXPECT_EQ((*answer)["X-Content-Type-Options"], "nosniff");
    EXPECT_EQ((*answer)["Referrer-Policy"], "no-referrer");
  }
}

TEST(PageAnswer, SaysWhatEachFileIs) {
  const auto type_of = [](const std::string& path) {
    return std::string((*answer_to(http::verb::get, path))[http::field::content_type]);
  };
  EXPECT_EQ(type_of("/page/index.html"), "text/html; charset=utf-8");
  EXPECT_EQ(type_of("/page/page.css"), "text/css; charset=utf-8");
  EXPECT_EQ(type_of("/page/main.js"), "text/javascript; charset=utf-8");
  EXPECT_EQ(type_of("/page/icon.svg"), "image/svg+xml");
}

TEST(PageAnswer, IsNoneForWhatIsNotOfThePage) {
  for (const char* path : {"/page", "/page/", "/page/other.js", "/page/../main.js", "/index.html",
                           "/api/v1/status", ""}) {
    EXPECT_FALSE(answer_to(http::verb::get, path)) << path;
  }
}

TEST(PageAnswer, RefusesWhatDoesNotRead) {
  const auto answer = answer_to(http::verb::post, "/");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->result(), http::status::method_not_allowed);
  EXPECT_EQ((*answer)[http::field::allow], "GET, HEAD");
  EXPECT_EQ(answer->body(), "{\"error\":\"expected GET or HEAD\"}\n");
}

TEST(PageAnswer, SendsNothingThatIsKnownAlready) {
  auto again = asked_for(http::verb::get, "/page/main.js");
  again.set(http::field::if_none_match,
            (*answer_to(http::verb::get, "/page/main.js"))[http::field::etag]);
  const auto same = page_answer(again, "/page/main.js");
  EXPECT_EQ(same->result(), http::status::not_modified);
  EXPECT_EQ(same->body(), "");
  EXPECT_EQ((*same)[http::field::cache_control], "no-cache");
  again.set(http::field::if_none_match, "\"another\"");
  EXPECT_EQ(page_answer(again, "/page/main.js")->result(), http::status::ok);
}

}  // namespace
}  // namespace mbgate::app
