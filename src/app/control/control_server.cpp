// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_server.hpp"

#include <algorithm>
#include <boost/beast/http.hpp>
#include <boost/json/array.hpp>
#include <iterator>
#include <new>
#include <string_view>

#include "app/control/control_answers.hpp"
#include "app/control/tcp_rules.hpp"
#include "app/metrics/metrics.hpp"
#include "app/page/page_answer.hpp"
#include "app/text.hpp"

namespace mbgate::app {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

/// A gateway that does not answer within this is not well.
constexpr std::chrono::seconds kAnswerLimit{1};
/// Reading a configuration may wait for a slow disk.
constexpr std::chrono::seconds kReloadLimit{30};
constexpr std::string_view kTooManyCommands = "more than 10 commands (POST) within a second";
constexpr std::string_view kNoAnswer = "the gateway has not answered within 1 s";
constexpr std::string_view kOverdueText = "a bus has missed its deadline";
constexpr std::string_view kEventsPath = "/api/v1/events";
constexpr std::string_view kTracePath = "/api/v1/trace";

}  // namespace

ControlServer::ControlServer(const std::shared_ptr<asio::io_context>& home,
                             asio::io_context& gateway, ControlTarget& target,
                             std::uint64_t numbered_from, TraceStreams::Switch set_traced)
    : home_(home),
      gateway_(gateway),
      target_(target),
      doors_(
          home,
          [this](ControlDoors::Entered client) {
            io::supervise(*home_, serve_one(std::move(client)), "control connection");
          },
          [this](const std::string& address) {
            asio::post(gateway_, [&target = target_, address] { target.http_refused(address); });
          }),
      events_(numbered_from),
      traces_(std::move(set_traced)) {}

void ControlServer::apply(const gateway::HttpSettings& settings) {
  doors_.allow(settings.allow);
  hosts_ = settings.hosts;
  streams_.set_most(settings.max_streams);
  client_metrics_ = settings.client_metrics;
}

asio::awaitable<void> ControlServer::serve_one(ControlDoors::Entered client) {
  const auto stream = co_await serve(client);
  client.place.reset();  // a stream is counted as one
  if (!stream) {
    co_return;
  }
  const auto place = streams_.take({client.asker.client, client.over_tcp});
  if (const auto* after = std::get_if<std::uint64_t>(&*stream)) {
    co_await events_.feed(*client.stream, *after);
  } else {
    const auto& filter = std::get<TraceFilter>(*stream);
    co_await traces_.feed(*client.stream, filter,
                          filter.with_journal ? events_.kept() : std::function<std::string()>());
  }
}

std::optional<Result<ControlServer::Stream, Refusal>> ControlServer::begin_stream(
    const Request& request, const StreamPlaces::Reader& asker) {
  const auto as_stream = [](const auto& begin) {
    return begin ? Result<Stream, Refusal>(Stream(*begin))
                 : Result<Stream, Refusal>(boost::system::in_place_error, begin.error());
  };
  const bool is_of_events = path_of(request) == kEventsPath;
  if (request.method() != http::verb::get || (!is_of_events && path_of(request) != kTracePath)) {
    return std::nullopt;
  }
  if (auto full = streams_.refusal(asker)) {
    return Refusal{http::status::service_unavailable, *std::move(full)};
  }
  return is_of_events ? as_stream(events_.begin(value_of(request, "Last-Event-ID")))
                      : as_stream(TraceStreams::begin(query_of(request)));
}

std::optional<Refusal> ControlServer::refused(const ControlDoors::Entered& client,
                                              const RequestReader::Incoming& incoming) {
  const Request& request = incoming.request;
  const bool is_command = !client.over_tcp && request.method() == http::verb::post;
  if (is_command) {
    const auto verdict = commands_.count(client.asker.client, std::chrono::steady_clock::now());
    if (verdict == CommandLimit::Verdict::first_too_many) {
      tell_denied(std::string(kTooManyCommands), client.asker);
    }
    if (verdict != CommandLimit::Verdict::allowed) {
      return Refusal{http::status::too_many_requests, std::string(kTooManyCommands)};
    }
  }
  auto refusal = client.over_tcp ? refused_over_tcp(request, hosts_) : refused_over_socket(request);
  // A head that is not whole may lack its Host.
  if (incoming.refusal && (!refusal || refusal->status == http::status::bad_request)) {
    refusal = incoming.refusal;
  }
  if (refusal && is_command) {
    tell_denied(denied_text(request, refusal->status), client.asker);
  }
  return refusal;
}

void ControlServer::tell_denied(const std::string& what, const Asker& asker) {
  asio::post(gateway_, [&target = target_, what, asker] { target.command_denied(asker, what); });
}

asio::awaitable<std::optional<ControlServer::Stream>> ControlServer::serve(
    ControlDoors::Entered& client) {
  ControlStream& stream = *client.stream;
  RequestReader reader(stream);
  bool goes_on = true;
  while (goes_on) {
    client.place->wait();
    const auto incoming = co_await reader.read();
    if (!incoming) {
      break;
    }
    const Request& request = incoming->request;
    client.place->answer(request.method() == http::verb::post);
    Response response;
    if (const auto refusal = refused(client, *incoming)) {
      response = answer(request, refusal->status, error_json(refusal->why));
    } else if (const auto stream_asked =
                   begin_stream(request, {client.asker.client, client.over_tcp})) {
      if (*stream_asked) {
        co_return **stream_asked;
      }
      const Refusal& why_not = stream_asked->error();
      response = answer(request, why_not.status, error_json(why_not.why));
    } else {
      response = co_await respond(request, client.asker);
      if (is_command_failed(request, response.result())) {
        tell_denied(denied_text(request, response.result()), client.asker);
      }
    }
    if (incoming->refusal) {
      response.keep_alive(false);  // its body follows, and is not read
    }
    goes_on = response.keep_alive();
    if (request.method() == http::verb::head) {
      response.body().clear();  // its length stays
    }
    client.place->wait();
    stream.expires_after(kClientLimit);
    const auto [write_error, sent] = co_await http::async_write(stream, response, io::kAsTuple);
    goes_on = goes_on && !write_error;
  }
  co_return std::nullopt;
}

asio::awaitable<ControlServer::Response> ControlServer::respond(const Request& request,
                                                                const Asker& asker) {
  const std::string_view path = path_of(request);
  if (auto page = page_answer(request, path)) {
    co_return *std::move(page);
  }
  const bool is_reload = path == "/api/v1/reload";
  const bool is_command = is_reload || path == "/api/v1/clear-counters";
  const bool is_stream = path == kEventsPath || path == kTracePath;
  if (!is_command && !is_stream && path != "/api/v1/status" && path != "/healthz" &&
      path != "/metrics") {
    co_return answer(
        request, http::status::not_found,
        error_json("expected GET /, /api/v1/status, /api/v1/events, /api/v1/trace, /metrics or "
                   "/healthz, POST /api/v1/reload or POST /api/v1/clear-counters"));
  }
  const auto wanted = is_command ? http::verb::post : http::verb::get;
  if (request.method() != wanted) {
    co_return wrong_method(request, is_command ? "POST" : "GET");
  }
  if (is_reload) {
    co_return co_await reload(request, asker);
  }
  if (is_command) {
    co_return co_await clear_counters(request, asker);
  }
  if (path == "/healthz") {
    co_return co_await health(request);
  }
  if (path == "/metrics") {
    co_return co_await metrics(request);
  }
  co_return co_await status(request);
}

asio::awaitable<std::optional<ControlServer::Status>> ControlServer::ask_status(bool with_clients) {
  Question<Status> question(home_);
  asio::post(gateway_, [&target = target_, take = question.taker(), with_clients] {
    try {
      take({target.report_status(with_clients), target.process_status()});
    } catch (const std::bad_alloc&) {
      return;  // Who asks hears nothing: the gateway must not end for that.
    }
  });
  co_return co_await question.wait(kAnswerLimit);
}

asio::awaitable<ControlServer::Response> ControlServer::status(const Request& request) {
  const auto now = co_await ask_status(true);
  if (now) {
    last_ = status_json(now->report, now->process);
    last_at_ = std::chrono::steady_clock::now();
    co_return answer(request, http::status::ok, last_);
  }
  boost::json::object json = error_json(kNoAnswer);
  if (last_at_) {
    const auto age = std::chrono::steady_clock::now() - *last_at_;
    json["last_status"] = last_;
    json["last_status_age_s"] = std::chrono::duration<double>(age).count();
  }
  co_return answer(request, http::status::service_unavailable, json);
}

asio::awaitable<ControlServer::Response> ControlServer::metrics(const Request& request) {
  const auto now = co_await ask_status(client_metrics_);
  if (!now) {
    co_return answer(request, http::status::service_unavailable, error_json(kNoAnswer));
  }
  auto families = process_families();
  std::ranges::move(metric_families(now->report, now->process, client_metrics_),
                    std::back_inserter(families));
  Response response(http::status::ok, request.version());
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(request.keep_alive());
  response.body() = metrics_text(families);
  response.prepare_payload();
  co_return response;
}

asio::awaitable<ControlServer::Response> ControlServer::health(const Request& request) {
  Question<bool> question(home_);
  asio::post(gateway_,
             [&target = target_, take = question.taker()] { take(target.meets_deadlines()); });
  const auto is_well = co_await question.wait(kAnswerLimit);
  if (is_well && *is_well) {
    co_return answer(request, http::status::ok, {{"status", "ok"}});
  }
  co_return answer(request, http::status::service_unavailable,
                   error_json(is_well ? kOverdueText : kNoAnswer));
}

asio::awaitable<ControlServer::Response> ControlServer::clear_counters(const Request& request,
                                                                       const Asker& asker) {
  Question<bool> question(home_);
  asio::post(gateway_, [&target = target_, take = question.taker(),
                        is_awaited = question.is_awaited(), asker] {
    if (is_awaited()) {  // else it was answered that nothing was done
      target.clear_counters(asker);
      take(true);
    }
  });
  const auto done = co_await question.wait(kAnswerLimit);
  co_return done ? answer(request, http::status::ok, {{"result", "done"}})
                 : answer(request, http::status::service_unavailable, error_json(kNoAnswer));
}

asio::awaitable<ControlServer::Response> ControlServer::reload(const Request& request,
                                                               const Asker& asker) {
  Question<ReloadOutcome> question(home_);
  asio::post(gateway_,
             [&target = target_, take = question.taker(), asker] { target.reload(asker, take); });
  const auto outcome = co_await question.wait(kReloadLimit);
  if (!outcome) {
    co_return answer(
        request, http::status::service_unavailable,
        error_json("the reload has not ended within 30 s; the journal will have its result"));
  }
  const auto status = outcome->done ? http::status::ok : http::status::unprocessable_entity;
  co_return answer(request, status,
                   {{"result", outcome->done ? "done" : "refused"},
                    {"messages", array_of(outcome->messages, [](const std::string& message) {
                       return boost::json::string(valid_utf8(message));
                     })}});
}

}  // namespace mbgate::app
