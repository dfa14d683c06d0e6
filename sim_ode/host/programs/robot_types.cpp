#include "sim_ode/host/programs/robot_types.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <vector>

namespace arkmesh::sim_ode {
namespace {

bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

class Rewriter {
 public:
  Rewriter(std::string_view text, const std::filesystem::path& ours) : text_(text), ours_(ours) {}

  std::string run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      const bool begins = at_ == 0 || text_[at_ - 1] == '\n';
      if (begins && c == '#') {
        const std::string_view line = text_.substr(at_, text_.find('\n', at_) - at_);
        if (line.starts_with("# ")) of_program_ = program_follows(line, ours_);
        copy(line.size());
      } else if (c == '"' || c == '\'') {
        copy(quoted());
      } else if (std::isdigit(static_cast<unsigned char>(c)) || (c == '.' && std::isdigit(peek(1)))) {
        constant();
      } else if (in_word(c)) {
        word();
      } else {
        if (argument_depth_ > 0) argument_depth_ += c == '(' ? 1 : c == ')' ? -1 : 0;
        copy(1);
      }
    }
    return std::move(out_);
  }

 private:
  unsigned char peek(std::size_t ahead) const {
    return at_ + ahead < text_.size() ? static_cast<unsigned char>(text_[at_ + ahead]) : '\0';
  }
  void copy(std::size_t size) {
    out_ += text_.substr(at_, size);
    at_ += size;
  }
  std::string_view word_at(std::size_t at) const {
    std::size_t end = at;
    while (end < text_.size() && in_word(text_[end])) ++end;
    return text_.substr(at, end - at);
  }
  std::size_t quoted() const {
    std::size_t end = at_ + 1;
    while (end < text_.size() && text_[end] != text_[at_]) end += text_[end] == '\\' ? 2 : 1;
    return std::min(end + 1, text_.size()) - at_;
  }

  // A robot's fractions are single, and a long constant has 32 bits.
  void constant() {
    std::size_t end = at_;
    const auto exponent = [&](std::size_t at) { return std::string_view("eEpP").find(text_[at]) != std::string::npos; };
    while (end < text_.size() && (in_word(text_[end]) || text_[end] == '.' ||
                                  ((text_[end] == '+' || text_[end] == '-') && exponent(end - 1))))
      ++end;
    if (!of_program_) return copy(end - at_);
    std::string number(text_.substr(at_, end - at_));
    const bool hex = number.starts_with("0x") || number.starts_with("0X");
    const auto longs = std::ranges::count_if(number, [](char c) { return c == 'l' || c == 'L'; });
    if (number.find_first_of(hex ? "pP" : ".eE") != std::string::npos) {
      if (longs > 0) number.pop_back();
      if (longs > 0 || std::isdigit(static_cast<unsigned char>(number.back())) || number.back() == '.') number += 'f';
    } else if (longs == 1 && std::strtoull(number.c_str(), nullptr, 0) <= 0xFFFFFFFF) {
      std::erase_if(number, [](char c) { return c == 'l' || c == 'L'; });
    }
    out_ += number;
    at_ = end;
  }

  // The words of one type may stand in any order, with others such as const between them.
  void word() {
    static const std::set<std::string_view> of_type = {"signed", "unsigned", "short", "long", "int", "double", "char"};
    static const std::set<std::string_view> between = {"const",  "volatile", "static",   "extern", "register",
                                                       "inline", "typedef",  "restrict", "auto",   "__extension__"};
    std::vector<std::pair<std::size_t, std::string_view>> found;
    for (std::size_t at = at_; of_program_;) {
      const std::string_view next = word_at(at);
      if (of_type.contains(next))
        found.emplace_back(at, next);
      else if (found.empty() || !between.contains(next))
        break;
      at += next.size();
      while (at < text_.size() && std::isspace(static_cast<unsigned char>(text_[at]))) ++at;
    }
    if (found.empty()) {
      const std::string_view name = word_at(at_);
      copy(name.size());
      // what is passed so has a PC's int and double
      if (name == "__builtin_va_arg" && text_.find('(', at_) != std::string_view::npos) {
        copy(text_.find('(', at_) + 1 - at_);
        argument_depth_ = 1;
      }
      return;
    }
    const auto count = [&](std::string_view what) {
      return std::ranges::count_if(found, [&](const auto& one) { return one.second == what; });
    };
    std::string type;
    if (count("char") + count("short") > 0 || count("long") > 1) {
    } else if (count("double") > 0) {
      if (argument_depth_ == 0) type = "float";
    } else if (count("long") == 1 || argument_depth_ == 0) {
      type = count("long") == 1 ? "int" : "short";
      if (count("unsigned") > 0) type = "unsigned " + type;
    }
    const std::size_t end = found.back().first + found.back().second.size();
    if (type.empty()) return copy(end - at_);
    for (const auto& [at, old] : found) {
      copy(at - at_);
      out_ += type;
      type.clear();
      at_ += old.size();
    }
  }

  const std::string_view text_;
  const std::filesystem::path& ours_;
  std::string out_;
  std::size_t at_ = 0;
  bool of_program_ = true;
  int argument_depth_ = 0;  // of parentheses in __builtin_va_arg(...); 0: outside
};

}  // namespace

bool program_follows(std::string_view marker, const std::filesystem::path& ours) {
  const std::size_t begin = marker.find('"'), end = marker.rfind('"');
  if (begin == std::string_view::npos || end == begin) return true;
  const std::string flags = std::string(marker.substr(end + 1)) + " ";
  return !marker.substr(begin + 1).starts_with(ours.string() + "/") && flags.find(" 3 ") == std::string::npos;
}

std::string with_robot_types(const std::string& expanded, const std::filesystem::path& ours) {
  return Rewriter(expanded, ours).run();
}

}  // namespace arkmesh::sim_ode
