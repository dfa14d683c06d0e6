// Copies straight from one bus's handlers to the other bus; holds no message back.
#include "hal/bus/tap.hpp"

#include <map>

namespace arkmesh::hal {

struct Tap::State {
  Bus& private_bus;
  Bus& public_bus;
  // Asks LCM itself which channel names the inputs match: a name matches when a message on it is delivered here.
  Bus matcher{"memq://"};
  std::map<std::string, bool, std::less<>> is_input = {};  // answers so far
  std::string channel_name = {};                           // reused: no allocation per message
  std::vector<std::unique_ptr<Bus::Subscription>> subscriptions = {};

  // Whether messages of this name come from outside: then they are never copied out.
  bool comes_in(std::string_view channel) {
    if (const auto it = is_input.find(channel); it != is_input.end()) return it->second;
    if (is_input.size() >= 10'000) is_input.clear();  // others choose the names that come in
    matcher.publish(std::string(channel), {});
    return is_input.emplace(channel, matcher.drain() > 0).first->second;
  }
};

Tap::Tap(Bus& private_bus, Bus& public_bus, const std::vector<std::string>& inputs)
    : state_(new State{private_bus, public_bus}) {
  State& state = *state_;
  const auto copy_to = [&state](Bus& bus, std::string_view channel, std::span<const std::byte> bytes) {
    state.channel_name = channel;
    bus.publish(state.channel_name, bytes);
  };
  for (const std::string& input : inputs) {
    state.subscriptions.push_back(state.matcher.subscribe(input, [](std::string_view, std::span<const std::byte>) {}));
    state.subscriptions.push_back(public_bus.subscribe(input, [&state, copy_to](std::string_view channel, auto bytes) {
      copy_to(state.private_bus, channel, bytes);
    }));
  }
  state.subscriptions.push_back(private_bus.subscribe(".*", [&state, copy_to](std::string_view channel, auto bytes) {
    if (!state.comes_in(channel)) copy_to(state.public_bus, channel, bytes);
  }));
}

Tap::~Tap() = default;

}  // namespace arkmesh::hal
