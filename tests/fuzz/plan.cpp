// SPDX-License-Identifier: Apache-2.0
// Any request to any drives by any route: what goes on the bus keeps to the drives' limits, every
// register reaches its place once, and what the client gets is what the drive holds.
#include "routing/plan.hpp"

#include <vector>

#include "fuzz/plan_refusal.hpp"
#include "fuzz/plan_scene.hpp"
#include "fuzz/responses.hpp"
#include "modbus/response.hpp"
#include "support/plan_answer.hpp"

namespace mbgate::fuzz::plan_target {
namespace {

using drive::Transaction;
using modbus::Request;
using modbus::ResponseFit;
using routing::Plan;

constexpr std::uint8_t kAutonicsAddress = 129;

/// Those whose data the plain device understands.
bool moves_data(std::uint8_t function) {
  return (function >= 1 && function <= 6) || function == 0x0F || function == 0x10 ||
         function == 0x16 || function == 0x17;
}

void check_limits(const drive::Device& device, const Request& request) {
  const auto check = [&](const std::optional<modbus::AddressField>& field, std::uint16_t limit) {
    if (field) {
      require(field->range.count <= limit, "a transaction is within the drive's limits");
      require(!crosses_group(device, asked(field->range)),
              "a transaction stays in its parameter group");
    }
  };
  if (request.reads() && request.function() != 0x18) {
    check(request.reads(), device.profile.limits.read_from(request.reads()->range.table));
  }
  if (request.writes()) {
    check(request.writes(), device.profile.limits.written_to(request.writes()->range.table));
  }
}

/// What starts motion is written whole; what the gateway cuts, it does not cut through a value.
void check_values(const Scene& scene, const Plan& plan) {
  const drive::Device& device = scene.device();
  const ClientView view = view_of(scene, device);
  const Transaction* before = nullptr;
  for (const Transaction& transaction : plan.transactions()) {
    const auto& writes = transaction.request.writes();
    for (const drive::Value& value : device.profile.values.all()) {
      if (writes && value.motion && drive::overlap(value.range(), writes->range)) {
        require(writes->range.first <= value.first && value.end() <= drive::end_of(writes->range),
                "a value that starts motion is written whole");
      }
    }
    const bool splits_values = device.split_values && device.write_function == 6;
    const auto& field = writes ? writes : transaction.request.reads();
    if (transaction.must_hold != nullptr || !field) {
      continue;
    }
    if (before != nullptr) {
      const auto& last = writes ? before->request.writes() : before->request.reads();
      require(drive::end_of(last->range) == field->range.first, "nothing is missing or twice");
      const drive::Value* value = view.value_at(field->range.table, field->range.first);
      require(value == nullptr || value->first == field->range.first ||
                  (writes && splits_values && !value->motion),
              "no cut goes through a value");
    }
    before = &transaction;
  }
}

/// What the drive would answer, and what the client gets of it.
void check_data(const Scene& scene, const Plan& plan, const Request& request) {
  const drive::Device& device = scene.device();
  const ClientView view = view_of(scene, device);
  PlainDevice real(is_one_memory(scene));
  PlainDevice expected(is_one_memory(scene));
  const auto answer = view.carry_out(expected, request.pdu().bytes());
  std::vector<modbus::Pdu> responses;
  for (const Transaction& transaction : plan.transactions()) {
    if (transaction.must_hold == nullptr) {
      responses.push_back(*modbus::Pdu::from(real.carry_out(transaction.request.pdu().bytes())));
    }
  }
  require(real.written() == expected.written(), "every register is written once, at its place");
  require(real.cells() == expected.cells(), "what is written is what the client wants");
  require(test::answer_of(plan, responses) == modbus::Pdu::from(answer),
          "the client sees what is there");
}

void check_answer(const Plan& plan, const Request& request, Script& script) {
  std::vector<modbus::Pdu> answers;
  for (const auto& transaction : plan.transactions()) {
    if (transaction.must_hold != nullptr) {
      continue;
    }
    answers.push_back(response_to(transaction.request, script));
    const auto fit = modbus::check_response(transaction.request, answers.back().bytes());
    if (fit == ResponseFit::exception) {
      break;
    }
    if (fit != ResponseFit::normal) {
      return;  // no bus would take it
    }
  }
  const auto fit = modbus::check_response(request, test::answer_of(plan, answers).bytes());
  require(fit == (answers.back().is_exception() ? ResponseFit::exception : ResponseFit::normal),
          "the answer fits the client's request");
}

/// The gateway's own question goes before what depends on it.
void check_question(const Scene& scene, const Plan& plan, std::size_t at) {
  const Transaction& question = plan.transactions()[at];
  require(!plan.is_read() && at + 1 < plan.transactions().size(), "a write follows a question");
  const auto asks = [&](const drive::Device& device) {
    return device.bus == question.bus && device.address == question.address &&
           device.verify_word_order &&
           question.must_hold->front() == (device.word_order == WordOrder::big ? 5 : 133);
  };
  require(std::ranges::any_of(scene.devices, asks), "a drive that is asked has to be");
  const auto& reads = question.request.reads();
  require(
      reads && !question.request.writes() && reads->range.first == 0x400 && reads->range.count == 1,
      "a question reads the register of the word order");
}

void check_unicast(const Scene& scene, const Plan& plan, const Request& request, Script& script) {
  for (const Transaction& transaction : plan.transactions()) {
    require(transaction.bus == scene.resolved.route.buses.front() &&
                transaction.address == kFirstAddress + scene.unit - kFirstUnit &&
                transaction.broadcast == std::nullopt,
            "a request goes where its unit leads");
    if (scene.resolved.device != nullptr) {
      check_limits(scene.device(), transaction.request);
    }
  }
  if (scene.resolved.device != nullptr) {
    check_values(scene, plan);
  }
  check_answer(plan, request, script);
  if (moves_data(request.function())) {
    check_data(scene, plan, request);
  }
}

/// What reaches one drive, or one of which nothing is known.
void check_hearer(const Scene& scene, const drive::Device& device, const Plan& plan,
                  const Request& request) {
  const bool autonics = device.profile.broadcast.form == BroadcastForm{129, 0x80};
  const bool is_meant = device.profile.broadcast.form != std::nullopt &&
                        (autonics || !scene.resolved.only_form) && takes(scene, device, request);
  PlainDevice real;
  PlainDevice expected;
  const ClientView view = view_of(scene, device);
  view.carry_out(expected, request.pdu().bytes());
  std::size_t heard = 0;
  for (const Transaction& transaction : plan.transactions()) {
    if (transaction.bus == device.bus && transaction.must_hold == nullptr &&
        (transaction.address == kAutonicsAddress) == autonics) {
      ++heard;
      real.carry_out(transaction.request.pdu().bytes());
    }
  }
  require(heard <= 1, "nobody hears a broadcast twice");
  require(heard == 1 || !is_meant, "everybody who is meant hears a broadcast");
  if (heard == 1 && (!autonics || is_meant)) {
    require(real.written() == expected.written(), "every register is written once, at its place");
    require(real.cells() == expected.cells(), "what is heard is what the client wants");
  }
}

void check_broadcast(const Scene& scene, const Plan& plan, const Request& request) {
  for (const Transaction& transaction : plan.transactions()) {
    if (transaction.must_hold == nullptr) {
      const bool autonics = transaction.broadcast == BroadcastForm{129, 0x80};
      require(transaction.broadcast != std::nullopt &&
                  transaction.address == (autonics ? kAutonicsAddress : 0),
              "a broadcast has the address of its form");
      require(!scene.resolved.only_form || transaction.broadcast == *scene.resolved.only_form,
              "only the form that was addressed is sent");
    }
  }
  for (const routing::BusDevices& known : scene.resolved.devices_of_buses) {
    for (const drive::Device* device : known.devices) {
      check_hearer(scene, *device, plan, request);
    }
    if (known.devices.empty()) {
      drive::Device unknown;
      unknown.bus = known.bus;
      unknown.word_order = scene.resolved.route.word_order;
      if (scene.devices.empty()) {
        check_hearer(scene, unknown, plan, request);
      }
    }
  }
  PlainDevice somebody;
  drive::Device plain;
  const auto answer = view_of(scene, plain).carry_out(somebody, request.pdu().bytes());
  require(plan.echo() == modbus::Pdu::from(answer), "the client gets the echo of its request");
}

void check_plan(const Scene& scene, const Plan& plan, const Request& request, Script& script) {
  require(!plan.transactions().empty(), "a plan does something");
  for (std::size_t at = 0; at < plan.transactions().size(); ++at) {
    const Transaction& transaction = plan.transactions()[at];
    require(Request::parse(transaction.request.pdu()).has_value(), "a transaction is well-formed");
    require(plan.is_read() <= transaction.request.is_read(), "a read writes nothing");
    if (transaction.must_hold != nullptr) {
      check_question(scene, plan, at);
    }
  }
  scene.resolved.is_broadcast() ? check_broadcast(scene, plan, request)
                                : check_unicast(scene, plan, request, script);
}

}  // namespace

MBGATE_FUZZ_TARGET(plan) {
  using namespace mbgate::fuzz;
  Script script(data, size);
  Scene scene;
  read_scene(script, scene);
  const auto pdu = modbus::Pdu::from(script.piece());
  if (!pdu || !modbus::is_request_function(pdu->function())) {
    return 0;
  }
  const routing::ClientRights rights{script.flag()};
  const auto plan = routing::Plan::make(scene.resolved, scene.unit, rights, *pdu);
  const auto request = modbus::Request::parse(*pdu);
  if (plan) {
    require(request.has_value(), "a plan is made of a well-formed request only");
    check_plan(scene, *plan, *request, script);
  } else if (request && !rights.read_only) {
    require(scene.resolved.is_broadcast() ? broadcast_may_be_refused(scene, *request)
                                          : may_be_refused(scene, *request),
            "a refusal has a reason");
  }
  return 0;
}

}  // namespace mbgate::fuzz::plan_target
