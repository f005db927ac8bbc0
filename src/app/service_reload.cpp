// SPDX-License-Identifier: Apache-2.0
// A reload: the configuration is read on a thread that may wait, and put into force if it is good.
#include <algorithm>
#include <fmt/core.h>
#include <iterator>
#include <memory>
#include <utility>

#include "app/changes.hpp"
#include "app/configuration/digest.hpp"
#include "app/service.hpp"
#include "app/systemd.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "io/clients/resources.hpp"

namespace mbgate::app {

using gateway::BusId;
using gateway::ListenerId;

namespace {

constexpr const char* kReloadDone = "reload: done";

}  // namespace

void Service::begin_reload() {
  if (reloading_) {
    read_again_ = true;
    return;
  }
  notify_reloading();
  reload_messages_.clear();
  reload_waiting_ = std::exchange(reload_asked_, {});
  reloading_ = blocking_.run(read_, [this](const Configuration& read) { finish_reload(read); });
  if (!reloading_) {
    say_of_reload(Level::error,
                  "the configuration stays as it is: no thread is available to read it",
                  message_id::kConfigurationKept);
    end_reload(false);
  }
}

void Service::end_reload(bool done) {
  reloading_ = false;
  is_refused_ = !done;
  if (done) {
    read_at_ = std::chrono::system_clock::now();
  }
  last_status_ = status();
  notify_ready(last_status_);
  for (const ReloadEnded& ended : std::exchange(reload_waiting_, {})) {
    ended({done, reload_messages_});
  }
  if (std::exchange(read_again_, false)) {
    begin_reload();
  }
}

void Service::say_who_reloads(const std::string& kind, const std::string& who) {
  log_.write_limited(Level::notice, "reload asked " + kind, "reload: asked for by " + who,
                     {.id = message_id::kReloadAsked});
}

void Service::command_denied(const Asker& asker, const std::string& what) {
  log_.write_limited(Level::warning, "command denied " + asker.client,
                     fmt::format("control socket: {}, asked by {}", what, asker.text),
                     {.id = message_id::kCommandDenied});
}

// What has changed is always said. With the rest, which is the same each time, whoever may ask for
// a reload could fill the journal.
void Service::say_of_reload(Level level, const std::string& text, MessageId id) {
  const bool is_change = id == message_id::kConfigurationChanged || text == kReloadDone;
  if (is_change) {
    log_.write(level, text, {.id = id});
  } else {
    log_.write_limited(level, "reload says " + text, text, {.id = id});
  }
  reload_messages_.push_back(text);
}

void Service::reload(const Asker& asker, ReloadEnded ended) {
  say_who_reloads(asker.client, "the control socket: " + asker.text);
  if (!ready_) {
    ended({false, {"mbgated is stopping"}});
    return;
  }
  reload_asked_.push_back(std::move(ended));
  begin_reload();
}

void Service::finish_reload(const Configuration& read) {
  if (!ready_) {
    return;  // the process ends
  }
  const auto end = [this](bool done) {
    if (!done) {
      say_of_reload(Level::error, "the configuration stays as it is",
                    message_id::kConfigurationKept);
    }
    end_reload(done);
  };
  if (!is_sound(read)) {
    end(false);
    return;
  }
  // A listener may have an address that the HTTP interface leaves.
  http_.make_room(read.loaded.settings->http,
                  [this, end, kept = std::make_shared<const Configuration>(read)] {
                    if (!ready_) {
                      return;
                    }
                    const bool done = change(*kept);
                    if (!done) {
                      http_.reload(driver_.settings().http);
                    }
                    end(done);
                  });
}

bool Service::is_sound(const Configuration& read) {
  if (!read.failure.empty()) {
    say_of_reload(Level::error, read.failure, message_id::kConfigurationWrong);
    return false;
  }
  for (const auto& diagnostic : read.loaded.diagnostics) {
    say_of_reload(diagnostic.severity == config::Severity::error ? Level::error : Level::warning,
                  config::headline(diagnostic), message_id::kConfigurationWrong);
  }
  if (!read.loaded.settings) {
    return false;
  }
  // An editor may have left an empty file behind.
  if (read.loaded.settings->buses.empty() && gateway::count_there(driver_.settings().buses) > 0) {
    say_of_reload(
        Level::error,
        "no [[bus]] is configured: expected at least one; only a restart removes all buses",
        message_id::kConfigurationWrong);
    return false;
  }
  const bool may = may_listen(*read.loaded.settings);
  return has_certificates(read.tls) && may;
}

bool Service::may_listen(const gateway::Settings& settings) {
  const auto open = io::open_listeners(settings, from_systemd_);
  for (const auto& listener : open) {
    say_of_reload(Level::error, listener, message_id::kConfigurationWrong);
  }
  return open.empty();
}

bool Service::has_certificates(const io::LoadedTls& tls) {
  for (const auto& failure : tls.failures) {
    say_of_reload(Level::error, failure, message_id::kCertificateWrong);
  }
  return tls.failures.empty();
}

void Service::use_certificates(const io::TlsContexts& contexts, const gateway::Settings& next) {
  driver_.use_tls(contexts, next);
  certificates_.use(contexts);
}

void Service::on_tls_refusal(const io::TlsPlace& place, const std::string& why) {
  certificates_.tell_refusal(driver_.settings().listener(place.listener).name, place, why);
}

bool Service::change(const Configuration& read) {
  const gateway::Settings before = driver_.settings();
  const gateway::Settings next = gateway::numbered_after(before, *read.loaded.settings);
  if (!listeners_.reload(before.listeners, next.listeners,
                         [this](ListenerId listener) { driver_.remove_servers(listener); })) {
    std::ranges::copy(listeners_.refusals(), std::back_inserter(reload_messages_));
    return false;
  }
  for (const auto& listener : next.listeners) {
    if (listener.is_gone) {
      from_systemd_.drop(listener.name);
    }
  }
  forget_failures(before, next);
  auto changes = changes_between(before, next);
  std::ranges::move(certificates_.changes(read.tls.contexts), std::back_inserter(changes));
  use_certificates(read.tls.contexts, next);
  driver_.reload(*read.loaded.settings, report::config_lines(read.files));
  control_.set_end(io::end_of_client_descriptors(next));
  if (!(before.http == next.http)) {
    http_.reload(next.http);
  }
  for (const auto& change : changes) {
    say_of_reload(Level::notice, "reload: " + change, message_id::kConfigurationChanged);
  }
  say_of_reload(Level::info, changes.empty() ? "reload: nothing has changed" : kReloadDone,
                message_id::kConfigurationInForce);
  const std::string digest_before = std::exchange(digest_, read.digest);
  say_of_reload(Level::info, in_force_text(digest_, digest_before),
                message_id::kConfigurationDigest);
  if (const auto room = io::room_for_clients(next, io::raise_descriptor_limit(), http_.inherited());
      room.shortage) {
    say_of_reload(Level::warning, *room.shortage, message_id::kTooFewDescriptors);
  }
  if (before.lock_memory != next.lock_memory) {
    say_of_reload(Level::warning, "reload: lock_memory takes effect at the next start",
                  message_id::kConfigurationNextStart);
  }
  if (before.control_socket != next.control_socket) {
    say_of_reload(Level::warning, "reload: [http] socket takes effect at the next start",
                  message_id::kConfigurationNextStart);
  }
  return true;
}

// What was said of another line may be wrong of this one, or is to be said again.
void Service::forget_failures(const gateway::Settings& before, const gateway::Settings& next) {
  failures_.resize(next.buses.size());
  for (std::size_t bus = 0; bus < before.buses.size(); ++bus) {
    if (!gateway::keeps_line(before, next, static_cast<BusId>(bus))) {
      failures_[bus].clear();
      warnings_.clear();
    }
  }
}

}  // namespace mbgate::app
