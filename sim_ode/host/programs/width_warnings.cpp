#include "sim_ode/host/programs/width_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// kilolib.h: ten bits of the converter.
constexpr long largest_reading = 1023;
// A number that calls of loop are compared with: fewer pass in a wink on a robot, more are meant as a time.
constexpr long many_calls = 1000;

// One operation: `place` "file:line", `to` = `from`.
struct Statement {
  std::string place, to, from;
};

bool signed_16(const std::string& type) {
  return type == "int" || type == "int16_t" || type == "short int";
}
bool unsigned_16(const std::string& type) {
  return type == "unsigned int" || type == "uint16_t" || type == "short unsigned int" || type == "size_t";
}
bool wide(const std::string& type) {
  return std::ranges::any_of(std::initializer_list<const char*>{"long", "32", "64", "float", "double"},
                             [&](const char* part) { return type.find(part) != std::string::npos; });
}
bool byte_type(const std::string& type) {
  return type == "unsigned char" || type == "uint8_t" || type == "char";
}

// Reads the functions of one source in the order of their statements.
class Reader {
 public:
  void take(const std::string& line) {
    static const std::regex begins(R"(^(\w+) \(.*\)$)"), declares(R"(^\s+(?:static )?([\w ]+?) ([\w.]+)(?: = .*)?;$)"),
        states(R"(^\s*(.+?)(?: = (.*))?;$)"), place(R"(\[([^\[\]]+):(\d+):\d+\] )");
    std::smatch found;
    if (std::regex_match(line, found, begins)) return begin(found[1]);
    const std::string bare = std::regex_replace(line, place, "");
    if (bare == line) {
      if (std::regex_match(line, found, declares)) types_[found[2]] = found[1];
      return;
    }
    std::regex_search(line, found, place);
    Statement one{fmt::format("{}:{}", fs::path(found[1].str()).filename().string(), found[2].str()), "", bare};
    if (std::smatch parts; std::regex_match(bare, parts, states)) {
      one.to = parts[2].matched ? parts[1].str() : "";
      one.from = parts[2].matched ? parts[2].str() : parts[1].str();
    }
    look(one);
  }

  // `said`: the compiler's words, of a whole program.
  std::vector<std::string> sentences(const std::string& said) {
    static const std::regex mixed(R"(([^/]+:\d+):\d+: warning: comparison between signed and unsigned)");
    std::smatch found;
    for (std::string_view left = said; !left.empty(); left.remove_prefix(std::min(left.size(), left.find('\n') + 1)))
      if (const std::string line(left.substr(0, left.find('\n'))); std::regex_search(line, found, mixed))
        if (const auto where = compared_.find(found[1]); where != compared_.end())
          tell_otherwise(where->second, where->first,
                         "a negative number is compared with an unsigned one, and counts as 65536 more in 16 bits");
    std::set<std::string> in_loop = {loop_};
    for (std::size_t before = 0; before != in_loop.size();) {
      before = in_loop.size();
      for (const auto& [caller, called] : calls_)
        if (in_loop.count(caller) > 0) in_loop.insert(called);
    }
    for (const auto& [counter, where] : counted_)
      if (const auto limit = limits_.find(counter);
          in_loop.count(where.first) > 0 && reads_clock_.count(where.first) == 0 && limit != limits_.end())
        tell(where.second,
             fmt::format("{} counts calls of loop up to {}: a robot calls it thousands of times in a tick, the "
                         "simulator once (arena.ode.loops_per_tick); use kilo_ticks to measure time",
                         counter, limit->second));
    std::ranges::stable_sort(said_, {}, [](const auto& one) {
      return std::pair(one.first.substr(0, one.first.rfind(':')),
                       std::atoi(one.first.c_str() + one.first.rfind(':') + 1));
    });
    std::vector<std::string> out;
    for (const auto& [where, what] : said_) out.push_back(fmt::format("{}: {}", where, what));
    return out;
  }
  std::vector<Otherwise> otherwise() { return std::move(otherwise_); }
  const std::multimap<std::string, std::string>& calls() const { return calls_; }

 private:
  void begin(const std::string& function) {
    function_ = function;
    std::erase_if(readings_, [&](const std::string& name) { return types_.count(name) > 0; });  // those of the last one
    types_.clear();
    bytes_.clear(), shifted_.clear(), copies_.clear(), sums_.clear(), one_more_.clear(), gaps_.clear();
  }

  static bool is_temporary(const std::string& name) {
    return name.find('.') != std::string::npos && name.find("->") == std::string::npos &&
           std::isdigit(static_cast<unsigned char>(name.back())) != 0;
  }
  std::string type_of(const std::string& name) const {
    const auto found = types_.find(name);
    return found == types_.end() ? "" : found->second;
  }
  // What a value that was just read is a copy of.
  std::string origin(const std::string& name) const {
    const auto found = copies_.find(name);
    return found == copies_.end() ? name : found->second;
  }
  void tell(const std::string& place, const std::string& what) {
    if (std::ranges::find(said_, std::pair(place, what)) == said_.end()) said_.emplace_back(place, what);
  }

  void tell_otherwise(const std::string& function, const std::string& place, const std::string& what) {
    tell(place, what);
    otherwise_.push_back({function, place, what, false});
  }
  bool perhaps_16(const std::string& operand) const {
    return std::isdigit(static_cast<unsigned char>(operand[0])) != 0 ? std::atoll(operand.c_str()) <= 65535
                                                                     : !wide(type_of(operand));
  }

  void look(const Statement& s) {
    static const std::regex comparison(R"(([\w.>-]+) (?:[<>]=?|[!=]=) ([\w.-]+))"), fraction(R"(\((float|double)\))");
    if (std::smatch sides; std::regex_search(s.from, sides, comparison) && perhaps_16(sides[1]) && perhaps_16(sides[2]))
      compared_.emplace(s.place, function_);
    if (std::regex_search(s.from, fraction) && (otherwise_.empty() || otherwise_.back().place != s.place))
      otherwise_.push_back(
          {function_, s.place, "floating-point numbers and their functions round differently on a robot", true});
    static const std::regex call(R"(^([A-Za-z_]\w*) \((.*)\)$)"), cast(R"(^\(([\w ]+)\) ([\w.>-]+)$)"),
        sum(R"(^([\w.]+) ([-+|*]) ([\w.]+|-?\d+)$)"), shift(R"(^([\w.]+) << (\d+)$)"), name(R"(^[\w.>\[\]-]+$)"),
        compared(R"(\b([A-Za-z_][\w.]*) (?:[<>=!]=?|%) (\d+)\b)");
    std::smatch part;
    if (s.from.find("kilo_ticks") != std::string::npos) reads_clock_.insert(function_);
    for (std::sregex_iterator at(s.from.begin(), s.from.end(), compared), end; at != end; ++at)
      if (const long limit = std::atol((*at)[2].str().c_str()); limit >= many_calls)
        limits_[origin((*at)[1])] = std::max(limits_[origin((*at)[1])], limit);
    if (std::regex_match(s.from, part, call)) {
      const std::string called = part[1];
      calls_.emplace(function_, called);
      static const std::regex started(R"((\w+), (\w+)$)");
      if (const std::string given = part[2]; called == "kilo_start" && std::regex_search(given, part, started))
        loop_ = part[2];
      if (called == "malloc" || called == "calloc" || called == "realloc" || called == "strdup")
        tell(s.place,
             fmt::format(
                 "{} shares its memory with the stack, and a robot does not detect their collision; use a static array",
                 called));
    }
    if (s.to.empty()) return;
    const std::string type = type_of(s.to);
    forget(s.to);
    if (s.from.starts_with("get_ambientlight (") || s.from.starts_with("get_voltage (") ||
        s.from.starts_with("get_temperature (")) {
      readings_.insert(s.to);
    } else if (std::regex_match(s.from, part, cast)) {
      const std::string from = part[2], wanted = part[1];
      if (byte_type(type_of(from))) bytes_.insert(s.to);
      if (readings_.count(from) > 0) readings_.insert(s.to);
      if (gaps_.count(from) > 0 && wide(wanted) && wanted.find("un") != 0 && wanted.find("uint") != 0)
        tell_otherwise(function_, s.place, "an unsigned 16-bit difference is never negative on a robot");
      if (shifted_.count(from) > 0 && !unsigned_16(wanted)) {
        if (signed_16(wanted))
          shifted_.insert(s.to);
        else if (!byte_type(wanted))
          tell_shift(s.place);
      }
      if (is_temporary(s.to)) copies_[s.to] = origin(from);
    } else if (std::regex_match(s.from, part, shift)) {
      if (signed_16(type) && bytes_.count(part[1]) > 0 && std::stoi(part[2]) >= 8) shifted_.insert(s.to);
    } else if (std::regex_match(s.from, part, sum)) {
      add(s, part[1], part[2].str()[0], part[3], type);
    } else if (std::regex_match(s.from, name)) {
      if (readings_.count(s.from) > 0) readings_.insert(s.to);
      if (shifted_.count(s.from) > 0) is_temporary(s.to) ? void(shifted_.insert(s.to)) : tell_shift(s.place);
      if (const auto one = one_more_.find(s.from);
          one != one_more_.end() && one->second == s.to && types_.count(s.to) == 0)
        counted_[s.to] = {function_, s.place};
      if (const auto total = sums_.find(s.from); total != sums_.end() && total->second == s.to) tell_sum(s.place, s.to);
      if (is_temporary(s.to)) copies_[s.to] = origin(s.from);
    }
  }

  void add(const Statement& s, const std::string& a, char sign, const std::string& b, const std::string& type) {
    const bool narrow = signed_16(type) || unsigned_16(type);
    if (sign == '*') {
      const long factor = std::atol(b.c_str());
      if (narrow && readings_.count(a) > 0 && std::abs(factor) * largest_reading > (signed_16(type) ? 32767 : 65535))
        tell(s.place,
             fmt::format("a reading, up to {}, times {} exceeds 16 bits; compute in int32_t", largest_reading, factor));
      return;
    }
    if ((sign == '|' || sign == '+') && signed_16(type) && (shifted_.count(a) > 0 || shifted_.count(b) > 0)) {
      if (is_temporary(s.to))
        shifted_.insert(s.to);
      else
        tell_shift(s.place);
    }
    if (unsigned_16(type) && (sign == '-' || (sign == '+' && std::atol(b.c_str()) > 32767))) gaps_.insert(s.to);
    if (sign == '+' && b == "1") one_more_[s.to] = origin(a);
    if (sign != '+' || !narrow) return;
    for (const auto& [total, summand] : {std::pair(a, b), std::pair(b, a)})
      if (readings_.count(summand) > 0 && readings_.count(total) == 0) {
        if (total == s.to)
          tell_sum(s.place, total);
        else
          sums_[s.to] = origin(total);
      }
  }

  void tell_shift(const std::string& place) {
    tell(place,
         "two bytes are shifted into an int of 16 bits, which is negative from 0x8000 on; (uint16_t)high << 8 | low is "
         "not");
  }
  void tell_sum(const std::string& place, const std::string& name) {
    tell(place, fmt::format("readings, up to {} each, are summed in {}, which has 16 bits; use int32_t",
                            largest_reading, name));
  }
  void forget(const std::string& name) {
    bytes_.erase(name), shifted_.erase(name), copies_.erase(name), sums_.erase(name), one_more_.erase(name);
    gaps_.erase(name);
    if (is_temporary(name)) readings_.erase(name);
  }

  std::string function_, loop_ = "loop";
  std::map<std::string, std::string> types_, copies_, sums_, one_more_;  // of one function; copies and sums: of what
  std::set<std::string> bytes_, shifted_, readings_, reads_clock_;
  std::set<std::string> gaps_;                   // differences of unsigned numbers
  std::map<std::string, std::string> compared_;  // {place: function}, of numbers that may have 16 bits
  std::vector<Otherwise> otherwise_;
  std::multimap<std::string, std::string> calls_;
  std::map<std::string, std::pair<std::string, std::string>> counted_;  // {what: {function, place}}
  std::map<std::string, long> limits_;
  std::vector<std::pair<std::string, std::string>> said_;
};

std::vector<fs::path> files_of(const fs::path& folder, const std::string& ending) {
  std::vector<fs::path> out;
  for (const fs::directory_entry& file : fs::directory_iterator(folder))
    if (const std::string name = file.path().filename().string();
        name.ends_with(ending) && !name.starts_with("kilolib."))
      out.push_back(file.path());
  std::ranges::sort(out);
  return out;
}

}  // namespace

const Otherwise* Widths::near(const std::string& function, const std::string& place) const {
  const auto line_of = [](const std::string& where) { return std::atoi(where.c_str() + where.rfind(':') + 1); };
  const Otherwise* out = nullptr;
  for (const Otherwise& one : otherwise)
    if (!place.empty() && one.function == function && line_of(one.place) <= line_of(place)) out = &one;
  std::vector<std::string> called = {function};
  for (std::size_t i = 0; i < called.size(); ++i)
    for (auto [from, end] = calls.equal_range(called[i]); from != end; ++from)
      if (std::ranges::find(called, from->second) == called.end()) called.push_back(from->second);
  for (const bool fraction : {false, true})
    for (const std::string& one_called : called)
      for (const Otherwise& one : otherwise)
        if (!out && one.function == one_called && one.fraction == fraction) out = &one;
  return out;
}

Widths widths_of(const fs::path& folder, const std::string& said) {
  Widths out;
  for (const fs::path& file : files_of(folder, ".gimple")) {
    Reader reader;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) reader.take(line);
    for (std::string& sentence : reader.sentences(said)) out.warnings.push_back(std::move(sentence));
    for (Otherwise& one : reader.otherwise()) out.otherwise.push_back(std::move(one));
    out.calls.insert(reader.calls().begin(), reader.calls().end());
  }
  return out;
}

Frame largest_frame(const fs::path& folder) {
  Frame out;
  for (const fs::path& file : files_of(folder, ".su")) {
    std::ifstream in(file);
    // path:line:column:function, bytes, how
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string where, bytes;
      std::getline(words, where, '\t'), std::getline(words, bytes, '\t');
      if (std::atoi(bytes.c_str()) <= out.bytes) continue;
      const std::size_t function = where.rfind(':'), column = where.rfind(':', function - 1);
      if (function == std::string::npos || column == std::string::npos) continue;
      out = {fs::path(where.substr(0, column)).filename().string(), where.substr(function + 1),
             std::atoi(bytes.c_str())};
    }
  }
  return out;
}

}  // namespace arkmesh::sim_ode
