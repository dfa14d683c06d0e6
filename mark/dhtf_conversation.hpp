// DHTF with an original: Init until it is acknowledged, then levels in both directions. The server's levels say which
// sites are inactive, the client's at which its team is complete.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mark/conversation.hpp"

namespace arkmesh::mark {

// The original is the client: it is told the sites and what became of them.
class DhtfServerConversation final : public Conversation {
 public:
  explicit DhtfServerConversation(std::size_t sites) : ready_(sites, 0), inactive_(sites, 0) {}
  void came() override { acked_ = false; }
  void gone() override { ready_.assign(ready_.size(), 0); }
  void hear(const Message& message) override;
  std::optional<std::string> say() const override;
  void said() override {}
  bool may_begin() const override { return true; }
  std::string awaited() const override { return {}; }
  void end() override {}  // what is inactive stays so: nothing more is done

  // All labs have met, and these are the sites.
  void set_init(Init init) { init_ = std::move(init); }
  void set_inactive(std::vector<int> inactive) { inactive_ = std::move(inactive); }
  // Per site, as it said last: its team is complete.
  const std::vector<int>& ready() const { return ready_; }
  bool acked() const { return acked_; }

 private:
  std::optional<Init> init_;
  bool acked_ = false;      // on this connection
  bool was_acked_ = false;  // on any
  std::vector<int> ready_, inactive_;
};

// The original is the server: it decides the sites and judges.
class DhtfClientConversation final : public Conversation {
 public:
  // `sites`: scenario.dhtf.sites, of `file`.
  DhtfClientConversation(std::size_t sites, Flavour flavour, std::string file)
      : flavour_(flavour), file_(std::move(file)), ready_(sites, 0), inactive_(sites, 0), executed_(sites, 0) {}
  void came() override { is_told_ = acked_ = ready_said_ = false; }
  void gone() override { ready_.assign(ready_.size(), 0); }
  void hear(const Message& message) override;
  std::optional<std::string> say() const override;
  void said() override;
  bool may_begin() const override { return init_.has_value(); }
  std::string awaited() const override { return "the Init"; }
  void end() override { ended_ = true; }

  const std::optional<Init>& init() const { return init_; }
  // It is the labs' world from now on: another one is refused.
  void keep() { is_kept_ = true; }
  // All labs have met: Init is acknowledged from now on.
  void go() { go_ = true; }
  // Per site: the teams of all other labs are complete.
  void set_ready(std::vector<int> ready) { ready_ = std::move(ready); }
  // Per site, as it said last, and how often each went inactive.
  const std::vector<int>& inactive() const { return inactive_; }
  const std::vector<std::int64_t>& executed() const { return executed_; }

 private:
  void hear_init(const std::string& text);
  void hear_accomplished(const std::string& text);

  Flavour flavour_;
  std::string file_;
  std::optional<Init> init_;
  bool is_kept_ = false, go_ = false, ended_ = false;
  bool is_told_ = false;     // Init, on this connection: another server draws other sites
  bool acked_ = false;       // what comes next is T
  bool ready_said_ = false;  // ARK-Qt, since the acknowledgement
  std::vector<int> ready_, inactive_;
  std::vector<std::int64_t> executed_;
};

}  // namespace arkmesh::mark
