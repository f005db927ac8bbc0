// SPDX-License-Identifier: Apache-2.0
// The line of a bus comes and goes.
#include <algorithm>
#include <utility>

#include "bus/bus.hpp"

namespace mbgate::bus {

void Bus::handle_opened(Instant now, LineKind kind) {
  link_.note_opened(now);
  adapter_.open(kind, now);
  devices_.forget_what_was_read();
  foreign_reported_ = false;
  own_heard_ = false;
  denied_echoes_ = 0;
  never_silent_reported_ = false;
  quality_.forget();
  line_.open(now, kind);
  pump(now);
}

void Bus::handle_lost(Instant now, Loss loss) {
  if (link_.is_resting()) {
    return;  // nobody has asked for a line
  }
  const bool in_order =
      line_.has_answered() || (line_.is_unused() && !link_.is_new(settings_, now));
  if (loss == Loss::closed && link_.is_open() && in_order) {
    line_.note_closed(now);
    rest(now);
    return;
  }
  counters_.losses += link_.serves() ? 1U : 0U;
  const auto due = line_.response_due();
  for (Job* job : running_) {
    if (due && job->in_flight && !job->on_wire().is_broadcast() &&
        !job->on_wire().may_stay_silent()) {
      devices_[job->on_wire().address].health.note_spoilt(job->on_wire().request, *due);
    }
  }
  line_.abort();
  looking_ = Looking::no;
  link_.note_lost(settings_, now);
  if (stopping_) {
    link_.stop();
  }
  end_running(Ending::closed);
  end_waiting(Ending::closed, true);
  pump(now);
}

// Who waits for the connection goes on waiting: it is opened again at once, or when somebody asks.
void Bus::rest(Instant now) {
  link_.rest(settings_, line_.has_answered());
  looking_ = Looking::no;
  line_.abort();
  for (Job* job : std::vector(running_)) {
    if (std::exchange(job->in_flight, false)) {
      handle_cut(*job, now);
    }
  }
  pump(now);
}

// Nobody knows whether the server has done what was on its way. A read does no harm if it is done
// twice; if the next connection is closed too before its answer, it has failed.
void Bus::handle_cut(Job& job, Instant now) {
  probes_.note_unanswered(job, now);
  if (job.job_class == JobClass::stop) {
    handle_failure(job, now);
  } else if (job.on_wire().request.is_read() && !job.is_probe && job.cut != job.current) {
    job.cut = job.current;
  } else {
    finish(job, Ending::no_answer);
  }
}

// The far end takes what is sent, and says nothing. Told once, until it says something again.
void Bus::replace(Instant now) {
  const bool is_news = line_.has_answered() || !replacement_reported_;
  replacement_reported_ = true;
  ++counters_.losses;
  actions_.push(ReplaceLine{is_news});
  rest(now);
}

// Only between transmissions, so that nothing on the wire is cut; what waits, and what is repeated,
// goes on once the line is open. A stop finds the line as it is.
bool Bus::reopen_if_hung(Instant now) {
  const bool stop_waits =
      queue_.first_stop() != nullptr || std::ranges::any_of(running_, [](const Job* job) {
        return job->job_class == JobClass::stop;
      });
  if (stopping_ || stop_waits || in_flight() > 0 || !adapter_.is_hung(settings_, now)) {
    return false;
  }
  link_.restart();
  looking_ = Looking::no;
  const ReopenLine reopen{adapter_.silence(now), adapter_.requests(), adapter_.note_reopening()};
  actions_.push(reopen);
  return true;
}

// What a close has cut, and what is repeated, waits for the line.
void Bus::wait_for_line() {
  const bool is_wanted = !running_.empty() || queue_.size() > 0 || queue_.first_stop() != nullptr;
  if (link_.is_resting() && is_wanted) {
    link_.wake();
    actions_.push(OpenLine{});
  }
}

}  // namespace mbgate::bus
