#include "omniflight_bus/participant.hpp"

#include <algorithm>
#include <cctype>

#include "endpoint.hpp"
#include "loopback_sockets.hpp"
#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/security.hpp"

namespace omniflight::bus {

detail::ParticipantState::~ParticipantState() {
  if (entity > 0) dds_delete(entity);
}

Result<Participant> Participant::create(int domain) {
  if (domain < 0 || domain > max_domain) {
    return bad_input("domain " + std::to_string(domain) + " does not exist", "domain",
                     "Choose 0 to " + std::to_string(max_domain));
  }
  auto state = std::make_shared<detail::ParticipantState>();
  state->domain = domain;
  const detail::QosHandle qos(dds_create_qos());
  const std::string user_data = "enclave=/;";  // lets ROS 2 count this process among its own
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  const auto before = loopback_promised() ? detail::sockets_on_all_interfaces() : std::set<int>();
  state->entity = dds_create_participant(static_cast<dds_domainid_t>(domain), qos.get(), nullptr);
  if (state->entity < 0) {
    return detail::dds_failure(
        state->entity, "cannot join domain " + std::to_string(domain),
        security_promised()
            ? "The lines of Cyclone DDS above say what is wrong with the keys; omniflight keys makes new ones"
            : "See that a network interface is up and that CYCLONEDDS_URI names a valid file");
  }
  if (loopback_promised())
    if (auto ok = detail::confine_to_loopback(before); !ok) return Failure(ok.error());
  auto graph = detail::RosGraph::open(state->entity);
  if (!graph) return Failure(graph.error());
  state->graph = std::move(*graph);
  return Participant(std::move(state));
}

int Participant::domain() const { return state_->domain; }

Result<Participant> Participant::as_node(const std::string& name) const {
  constexpr std::size_t kLongest = 255;  // RMW_NODE_NAME_MAX_NAME_LENGTH
  const bool letters = std::all_of(name.begin(), name.end(), [](char c) {
    return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0;
  });
  if (!letters || name.empty() || name.size() > kLongest || std::isdigit(static_cast<unsigned char>(name[0])))
    return bad_input("'" + name + "' is not a name of a node", "node",
                     "Use letters, digits and _, at most 255, no digit first");
  Participant out = *this;
  out.node_ = std::make_shared<detail::RosNode>(state_, name);
  return out;
}

Result<std::string> dds_topic_name(std::string_view ros_name) {
  const std::string_view name = ros_name.starts_with('/') ? ros_name.substr(1) : ros_name;
  bool valid = !name.empty() && name.size() <= 240;
  char previous = '/';
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    valid = valid && (c == '/' ? previous != '/'
                               : std::isalpha(u) || c == '_' || (std::isdigit(u) && previous != '/'));
    previous = c;
  }
  if (!valid || previous == '/') {
    return bad_input("'" + std::string(ros_name) + "' is not a topic name", "topic",
                     "Use letters, digits and _ in parts separated by /, such as /omni/pose");
  }
  return "rt/" + std::string(name);
}

}  // namespace omniflight::bus
