// The published M-ARK software as far as its peer notices it: what it reads, believes and sends in each of its ticks,
// with its habits: one recv() of a fixed length, no framing, the last message kept. Its robots are a dice. No time of
// its own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace arkmesh::tests {

class ScriptedOriginal {
 public:
  virtual ~ScriptedOriginal() = default;
  // Bytes have come into its socket's buffer.
  void receive(std::string_view segment) {
    socket_ += segment;
    most_unread = std::max(most_unread, socket_.size());
  }
  // One tick. What it sends in it, by one send(); nothing: it sends nothing.
  virtual std::string tick() {
    ++ticks;
    // A read per robot; each overwrites the last message.
    for (int robot = 0; robot < 32 && !socket_.empty(); ++robot) {
      const std::string bytes = socket_.substr(0, read_bytes_);
      socket_.erase(0, bytes.size());
      if (bytes.back() != '\0') ++cut_reads;
      last_ = bytes.substr(0, bytes.find('\0'));
      heard(last_);
    }
    return think() + '\0';
  }

  struct Done {
    std::size_t site;
    std::uint64_t tick;
  };
  std::vector<Done> done;  // tasks, as it believes
  std::uint64_t ticks = 0, cut_reads = 0;
  std::size_t most_unread = 0;

 protected:
  ScriptedOriginal(std::size_t read_bytes, unsigned seed) : read_bytes_(read_bytes), dice_(seed) {}
  virtual void heard(const std::string& text) = 0;
  virtual std::string think() = 0;
  std::string take_all() { return std::exchange(socket_, {}); }
  bool one_in(unsigned n) { return dice_() % n == 0; }
  const std::string& last() const { return last_; }

 private:
  std::size_t read_bytes_;
  std::mt19937 dice_;
  std::string socket_, last_;
};

// Robots at sites: they come and go, and are released when the task is done.
class DhtfOriginal : public ScriptedOriginal {
 public:
  std::vector<int> requirement;  // per site
  std::vector<int> active;       // 1 active, 0 inactive
  std::string types;             // of both sides, as Init gave them

 protected:
  explicit DhtfOriginal(unsigned seed) : ScriptedOriginal(30, seed) {}
  void begin(const std::vector<int>& hard) {
    for (const int h : hard) requirement.push_back(h ? 6 : 2);
    active.assign(hard.size(), 1);
    count_.assign(hard.size(), 0);
  }
  void walk() {
    for (std::size_t i = 0; i < count_.size(); ++i) {
      if (active[i] == 1 && count_[i] < 8 && one_in(60)) ++count_[i];
      if (count_[i] > 0 && one_in(400)) --count_[i];
    }
  }
  bool ready(std::size_t i) const { return count_[i] >= requirement[i]; }
  void release(std::size_t i) { count_[i] = 0; }

 private:
  std::vector<int> count_;
};

class DhtfOriginalClient final : public DhtfOriginal {
 public:
  explicit DhtfOriginalClient(unsigned seed) : DhtfOriginal(seed) {}
  std::string sites;

 private:
  void heard(const std::string& text) override {
    // Init is parsed once, from whatever one read returned.
    if (text.starts_with('I') && sites.empty()) {
      const std::size_t m = text.size() / 3;
      sites = text.substr(1, m);
      types = text.substr(1 + m);
      std::vector<int> hard;
      for (std::size_t i = 0; i < m; ++i) hard.push_back(types[m + i] == '1');
      begin(hard);
    }
    if (!text.starts_with('A')) return;
    for (std::size_t i = 0; i < active.size() && 1 + i < text.size(); ++i) {
      const int now = text[1 + i] == '0';
      if (active[i] == 1 && now == 0) {
        if (knows_activity_) done.push_back({i, ticks});
        release(i);
      }
      active[i] = now;
    }
    knows_activity_ = true;
  }
  bool knows_activity_ = false;  // sites that are inactive when it begins it takes for done by it
  std::string think() override {
    if (sites.empty()) return "Missing parameters";
    if (last().starts_with('I')) return "Received parameters";
    walk();
    std::string text = "T";
    for (std::size_t i = 0; i < active.size(); ++i) text += active[i] == 1 && ready(i) ? '1' : '0';
    return text;
  }
};

class DhtfOriginalServer final : public DhtfOriginal {
 public:
  DhtfOriginalServer(unsigned seed, std::string init) : DhtfOriginal(seed), init_(std::move(init)) {
    const std::size_t m = init_.size() / 3;
    types = init_.substr(1 + m);
    std::vector<int> hard;
    for (std::size_t i = 0; i < m; ++i) hard.push_back(types[i] == '1');
    begin(hard);
    inactive_since_.assign(m, 0);
  }
  std::uint64_t levels_sent = 0;

 private:
  void heard(const std::string&) override {}
  std::string think() override {
    if (!acked_ && !last().starts_with('R')) return init_;
    if (!std::exchange(acked_, true)) return {};
    ++levels_sent;
    walk();
    std::string text = "A";
    for (std::size_t i = 0; i < active.size(); ++i) {
      const bool theirs = last().starts_with('T') && 1 + i < last().size() && last()[1 + i] == '1';
      if (active[i] == 0 && ticks - inactive_since_[i] >= 400) active[i] = 1;
      if (active[i] == 1 && theirs && ready(i)) {
        active[i] = 0;
        inactive_since_[i] = ticks;
        release(i);
        done.push_back({i, ticks});
      }
      text += active[i] == 1 ? '0' : '1';
    }
    return text;
  }

  std::string init_;
  bool acked_ = false;
  std::vector<std::uint64_t> inactive_since_;
};

// ARK-Qt's service tick of 100 ms: it takes all that has come for one message, and what is longer kills it.
class ArkQtOriginal : public DhtfOriginal {
 public:
  bool died = false;
  std::string tick() final {
    ++ticks;
    if (const std::string bytes = take_all(); !bytes.empty()) {
      died = died || ((bytes[0] == 'T' || bytes[0] == 'A') && bytes.size() != 1 + active.size());
      heard(bytes);
    }
    return died ? "" : think();
  }

 protected:
  using DhtfOriginal::DhtfOriginal;
};

class ArkQtOriginalClient final : public ArkQtOriginal {
 public:
  explicit ArkQtOriginalClient(unsigned seed) : ArkQtOriginal(seed) {}
  std::string sites;

 private:
  void heard(const std::string& text) override {
    if (text[0] == 'I' && sites.empty()) {
      acknowledges_ = true;
      const std::size_t m = text.size() / 3;
      sites = text.substr(1, m);
      types = text.substr(1 + m);
      begin(std::vector<int>(m, 0));
    }
    for (std::size_t i = 0; text[0] == 'A' && i < active.size(); ++i) {
      const int now = text[1 + i] == '0';
      if (active[i] == 1 && now == 0) done.push_back({i, ticks}), release(i);
      active[i] = now;
    }
  }
  std::string think() override {
    if (sites.empty()) return ticks % 20 == 0 ? "Missing initialisation" : "";
    walk();
    if (std::exchange(acknowledges_, false)) return "Received initialisation";
    if (ticks % 15 != 0) return "";
    std::string text = "T";
    for (std::size_t i = 0; i < active.size(); ++i) text += active[i] == 1 && ready(i) ? '1' : '0';
    return text;
  }
  bool acknowledges_ = false;
};

// Silent while what it has heard last is the acknowledgement; T takes its place.
class ArkQtOriginalServer final : public ArkQtOriginal {
 public:
  ArkQtOriginalServer(unsigned seed, std::string init) : ArkQtOriginal(seed), init_(std::move(init)) {
    const std::size_t m = init_.size() / 3;
    begin(std::vector<int>(m, 0));
    inactive_since_.assign(m, 0);
  }
  // Stopped by its operator, and run again, with other sites: on the same connection, without a word, and silent for as
  // long as it had run before.
  void run_again(std::string init) {
    init_ = std::move(init);
    active.assign(active.size(), 1);
    clock_ = 0;
  }

 private:
  void heard(const std::string& text) override { held_ = text; }
  std::string think() override {
    ++clock_;
    if (ticks == 1) return "Reply: connection established";
    if (held_.starts_with('R')) return known_ = true, "";
    if (!known_ || held_.starts_with('M')) return init_;
    walk();
    if (clock_ < told_at_ + 20) return "";
    told_at_ = clock_;
    std::string text = "A";
    for (std::size_t i = 0; i < active.size(); ++i) {
      if (active[i] == 0 && ticks - inactive_since_[i] >= 400) active[i] = 1;
      if (active[i] == 1 && held_.starts_with('T') && held_[1 + i] == '1' && ready(i)) {
        active[i] = 0;
        inactive_since_[i] = ticks;
        release(i);
        done.push_back({i, ticks});
      }
      text += active[i] == 1 ? '0' : '1';
    }
    held_.clear();
    return text;
  }
  std::string init_, held_;
  bool known_ = false;
  std::uint64_t clock_ = 0, told_at_ = 0;
  std::vector<std::uint64_t> inactive_since_;
};

// The ground swarm: harvests by dice, and turns where a committed flying robot is over the other half.
class CreOriginalGround final : public ScriptedOriginal {
 public:
  CreOriginalGround(unsigned seed, int north, int south) : ScriptedOriginal(2000, seed) {
    for (int i = 0; i < 100; ++i) active.push_back(i < 50 ? i < north : i - 50 < south);
  }
  std::vector<int> active;
  std::vector<std::uint64_t> harvested{0, 0};
  std::string robots;              // as heard last
  std::uint64_t commands[2] = {};  // ticks in which some robot said north, south

 private:
  void heard(const std::string& text) override {
    robots = text;
    bool said[2] = {};
    for (std::size_t i = 0; i + 5 <= text.size(); i += 5) {
      const double y_m = 4 * ((text[i + 2] - '0') * 10 + (text[i + 3] - '0')) / 100.0 - 1;
      if (text[i + 4] == '1' && y_m < 0) said[0] = true;
      if (text[i + 4] == '2' && y_m > 0) said[1] = true;
    }
    commands[0] += said[0];
    commands[1] += said[1];
  }
  std::string think() override {
    for (std::size_t half = 0; half < 2; ++half) {
      if (!one_in(30)) continue;
      std::vector<std::size_t> here, free;
      for (std::size_t i = half * 50; i < half * 50 + 50; ++i) (active[i] ? here : free).push_back(i);
      active[here[dice(here.size())]] = 0;
      active[free[dice(free.size())]] = 1;
      ++harvested[half];
      done.push_back({half, ticks});
    }
    std::string text;
    for (const int one : active) text += one ? '0' : '1';
    return text;
  }
  std::size_t dice(std::size_t n) {
    std::size_t i = 0;
    while (!one_in(2) && i < 1000) ++i;
    return i % n;
  }
};

// The flying swarm: robots that wander and commit by dice.
class CreOriginalFlying final : public ScriptedOriginal {
 public:
  CreOriginalFlying(unsigned seed, std::size_t robots) : ScriptedOriginal(2000, seed), robots_(robots) {
    for (Robot& robot : robots_) robot.x = 10 + static_cast<int>(&robot - robots_.data()), robot.y = 25;
  }
  struct Robot {
    int x, y, commitment = 0;
  };
  const std::vector<Robot>& robots() const { return robots_; }
  std::string resources;  // as heard last

 private:
  void heard(const std::string& text) override { resources = text; }
  std::string think() override {
    std::string text;
    for (Robot& robot : robots_) {
      robot.x = std::clamp(robot.x + (one_in(10) ? 1 : 0) - (one_in(10) ? 1 : 0), 0, 50);
      robot.y = std::clamp(robot.y + (one_in(10) ? 1 : 0) - (one_in(10) ? 1 : 0), 0, 50);
      if (one_in(300)) robot.commitment = (robot.commitment + 1) % 3;
      for (const int number : {robot.x, robot.y}) {
        text += static_cast<char>('0' + number / 10);
        text += static_cast<char>('0' + number % 10);
      }
      text += static_cast<char>('0' + robot.commitment);
    }
    return text;
  }
  std::vector<Robot> robots_;
};

}  // namespace arkmesh::tests
