#include "sim_ode/host/proof/program_variables.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <stdexcept>

#include "hal/child_process.hpp"

namespace arkmesh::sim_ode {
namespace {

// One entry of the debugger's tables, as readelf prints them.
struct Entry {
  int depth = 0;
  std::string tag;
  std::map<std::string, std::string> says;
  std::vector<std::size_t> children;
  std::size_t parent = 0;
};

class Tables {
 public:
  explicit Tables(std::istream& text) {
    std::vector<std::size_t> path = {0};
    entries_.emplace_back();
    for (std::string line; std::getline(text, line);) {
      unsigned long offset = 0;
      int depth = 0, end = 0;
      char tag[80];
      if (std::sscanf(line.c_str(), " <%d><%lx>: Abbrev Number: %*d (DW_TAG_%79[^)]", &depth, &offset, tag) == 3) {
        path.resize(static_cast<std::size_t>(depth) + 1);
        entries_[path.back()].children.push_back(entries_.size());
        by_offset_[offset] = entries_.size();
        entries_.push_back({depth, tag, {}, {}, path.back()});
        path.push_back(entries_.size() - 1);
      } else if (std::sscanf(line.c_str(), " <%*x> DW_AT_%79[^: ] : %n", tag, &end) == 1 && end > 0) {
        std::string value = line.substr(static_cast<std::size_t>(end));
        if (value.starts_with("(indirect") || value.starts_with("(alt indirect")) value.erase(0, value.find("): ") + 3);
        while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.pop_back();
        entries_.back().says[tag] = value;
      }
    }
  }

  ProgramVariables variables() {
    std::set<std::string> twice;
    std::map<std::string, std::uint64_t> places;
    for (const Entry& entry : entries_) {
      const auto at = entry.says.find("location");
      if (entry.tag != "variable" || at == entry.says.end()) continue;
      const std::size_t address = at->second.find("DW_OP_addr: ");
      if (address == std::string::npos || at->second.find(';', address) != std::string::npos) continue;
      std::string name = text_of(entry, "name");
      if (name.empty()) continue;
      for (const Entry* in = &entries_[entry.parent]; in->depth > 0; in = &entries_[in->parent])
        if (in->tag == "subprogram") name = text_of(*in, "name") + ": " + name;
      const std::uint64_t place = std::strtoull(at->second.c_str() + address + 12, nullptr, 16);
      if (const auto [known, fresh] = places.emplace(name, place); !fresh) {
        if (known->second != place) twice.insert(name);
        continue;
      }
      whole_ = true;
      add(name, place, type_of(entry), 0);
      if (!whole_) out_.others.push_back(name);
    }
    // statics of two files with one name
    std::erase_if(out_.numbers,
                  [&](const auto& one) { return twice.contains(one.first.substr(0, one.first.find_first_of(".["))); });
    return std::move(out_);
  }

 private:
  static constexpr std::size_t most_numbers = 8000;

  const Entry* at(const std::string& reference) const {
    const auto found = by_offset_.find(std::strtoul(reference.c_str() + reference.find('<') + 1, nullptr, 16));
    return found == by_offset_.end() ? nullptr : &entries_[found->second];
  }
  // What it says itself, or what it is another description of.
  std::string text_of(const Entry& entry, const std::string& what) const {
    if (const auto found = entry.says.find(what); found != entry.says.end()) return found->second;
    for (const char* link : {"specification", "abstract_origin"})
      if (const auto found = entry.says.find(link); found != entry.says.end())
        if (const Entry* other = at(found->second)) return text_of(*other, what);
    return {};
  }
  unsigned number_of(const Entry& entry, const std::string& what) const {
    return static_cast<unsigned>(std::strtoul(text_of(entry, what).c_str(), nullptr, 0));
  }
  // Without names and qualifiers.
  const Entry* type_of(const Entry& entry) const {
    const std::string type = text_of(entry, "type");
    const Entry* found = type.empty() ? nullptr : at(type);
    static const std::set<std::string> passed = {"typedef", "const_type", "volatile_type", "restrict_type",
                                                 "atomic_type"};
    return found && passed.contains(found->tag) ? type_of(*found) : found;
  }
  unsigned size_of(const Entry* type) const {
    if (!type) return 0;
    if (type->tag != "array_type") return number_of(*type, "byte_size");
    unsigned size = size_of(type_of(*type));
    for (const std::size_t child : type->children) size *= length_of(entries_[child]);
    return size;
  }
  unsigned length_of(const Entry& range) const {
    if (range.tag != "subrange_type") return 1;
    if (range.says.contains("count")) return number_of(range, "count");
    return range.says.contains("upper_bound") ? number_of(range, "upper_bound") + 1 : 0;
  }

  void add(const std::string& name, std::uint64_t place, const Entry* type, std::size_t dimension) {
    if (!type || out_.numbers.size() > most_numbers) return;
    if (type->tag == "base_type" || type->tag == "enumeration_type") {
      const unsigned encoding = type->tag == "base_type" ? number_of(*type, "encoding") : 7;
      out_.numbers[name] = {place, number_of(*type, "byte_size"),
                            encoding == 4                    ? 'f'
                            : encoding == 5 || encoding == 6 ? 's'
                                                             : 'u'};
    } else if (type->tag == "array_type") {
      std::vector<unsigned> lengths;
      for (const std::size_t child : type->children)
        if (entries_[child].tag == "subrange_type") lengths.push_back(length_of(entries_[child]));
      if (dimension == lengths.size()) return add(name, place, type_of(*type), 0);
      unsigned stride = size_of(type_of(*type));
      for (std::size_t i = dimension + 1; i < lengths.size(); ++i) stride *= lengths[i];
      for (unsigned i = 0; i < lengths[dimension]; ++i)
        add(fmt::format("{}[{}]", name, i), place + i * stride, type, dimension + 1);
    } else if (type->tag == "structure_type") {
      for (const std::size_t child : type->children) {
        const Entry& member = entries_[child];
        if (member.tag != "member") continue;
        // readelf: "0", "2 byte block: 23 3 (DW_OP_plus_uconst: 3)"
        const std::string where = text_of(member, "data_member_location");
        const std::size_t of = where.find("uconst: ");
        const std::uint64_t offset = std::strtoull(where.c_str() + (of == std::string::npos ? 0 : of + 8), nullptr,
                                                   of == std::string::npos ? 0 : 10);
        if (member.says.contains("bit_size"))
          whole_ = false;
        else
          add(name + "." + text_of(member, "name"), place + offset, type_of(member), 0);
      }
    } else {
      whole_ = false;
    }
  }

  std::vector<Entry> entries_;
  std::map<unsigned long, std::size_t> by_offset_;
  ProgramVariables out_;
  bool whole_ = true;  // the present variable is compared in all its parts
};

}  // namespace

ProgramVariables ProgramVariables::read(const std::string& tool, const std::filesystem::path& object,
                                        const std::filesystem::path& scratch) {
  const std::filesystem::path text = scratch / "tables.txt";
  const hal::Finished done =
      hal::run_to_end({.command = {"sh", "-c", R"("$0" --debug-dump=info "$1" > "$2" 2>/dev/null)", tool,
                                   object.string(), text.string()}});
  std::ifstream in(text);
  if (done.status == 127 || !in) throw std::runtime_error(tool + " is missing; apt-get install binutils binutils-avr");
  return Tables(in).variables();
}

}  // namespace arkmesh::sim_ode
