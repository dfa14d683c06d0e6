#include "sim_ode/host/programs/program_sources.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

namespace arkmesh::sim_ode {

namespace fs = std::filesystem;

namespace {

bool is_c(const fs::path& file) {
  std::error_code ignored;
  return file.extension() == ".c" && fs::is_regular_file(file, ignored);
}

// Of the robot's library, which many keep beside their program.
bool is_of_kilolib(const fs::path& file) {
  static const std::set<fs::path> names = {"kilolib.c", "message_crc.c", "ohc.c", "bootldr.c"};
  std::error_code ignored;
  return names.contains(file.filename()) && fs::exists(file.parent_path() / "kilolib.h", ignored);
}

}  // namespace

std::string ProgramSources::name() const {
  if (paths.empty()) return "";
  const fs::path first = fs::absolute(paths.front()).lexically_normal();
  return (first.has_filename() ? first : first.parent_path()).filename().string();
}

fs::path one_spelling(const fs::path& file) {
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(fs::absolute(file).parent_path(), error);
  return error ? fs::absolute(file) : folder / file.filename();
}

std::vector<fs::path> files_of(const ProgramSources& program) {
  std::vector<fs::path> out;
  for (const fs::path& path : program.paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      out.push_back(path);
      continue;
    }
    const std::size_t before = out.size();
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error))
      if (is_c(at->path()) && !is_of_kilolib(at->path())) out.push_back(at->path());
    if (out.size() == before) throw ProgramError(fmt::format("{} holds no C file; name another folder", path.string()));
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(before), out.end());
  }
  std::set<fs::path> known;
  for (const fs::path& file : out)
    if (!known.insert(one_spelling(file)).second)
      throw ProgramError(fmt::format("{} is given twice; name each file once", file.string()));
  return out;
}

std::vector<bool> included_by_others(const std::vector<fs::path>& files,
                                     const std::vector<std::vector<std::string>>& read) {
  std::error_code ignored;
  std::vector<fs::path> names;
  for (const fs::path& file : files) names.push_back(fs::weakly_canonical(file, ignored));
  std::vector<bool> out(files.size());
  for (std::size_t reader = 0; reader < read.size(); ++reader)
    for (const std::string& path : read[reader]) {
      if (!path.ends_with(".c")) continue;
      const auto at =
          static_cast<std::size_t>(std::ranges::find(names, fs::weakly_canonical(path, ignored)) - names.begin());
      if (at < names.size() && at != reader) out[at] = true;
    }
  return out;
}

std::string wrong_with_macro(const std::string& macro) {
  const std::string name = macro.substr(0, macro.find('='));
  const auto is_of_name = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  const bool is_name =
      !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) && std::ranges::all_of(name, is_of_name);
  if (is_name && macro.find_first_of(std::string_view("\0\n", 2)) == std::string::npos) return {};
  return fmt::format("\"{}\" is not a macro; write NAME or NAME=VALUE", macro);
}

std::string read_source(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  const bool empty = in && in.peek() == std::ifstream::traits_type::eof();
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || !(empty || (in && text << in.rdbuf())))
    throw ProgramError(fmt::format("{} cannot be read; name a C file", file.string()));
  // some editors put a mark of three bytes before the first line
  std::string read = text.str();
  if (read.starts_with("\xEF\xBB\xBF")) read.erase(0, 3);
  return read;
}

ReadProgram::ReadProgram(const ProgramSources& program) : include(program.include), define(program.define) {
  for (const fs::path& file : files_of(program)) files.push_back({file, read_source(file)});
  for (const std::string& macro : define)
    if (const std::string wrong = wrong_with_macro(macro); !wrong.empty()) throw ProgramError(wrong);
  for (fs::path& folder : include) folder = fs::absolute(folder);
}

std::vector<fs::path> ReadProgram::folders_for(const fs::path& file) const {
  std::vector<fs::path> out{fs::absolute(file).parent_path()};
  const auto add = [&](const fs::path& folder) {
    if (std::ranges::find(out, folder) == out.end()) out.push_back(folder);
  };
  for (const fs::path& folder : include) add(folder);
  for (const File& other : files) add(fs::absolute(other.path).parent_path());
  return out;
}

std::vector<std::string> ReadProgram::options_for(const fs::path& file) const {
  std::vector<std::string> out;
  for (const fs::path& folder : folders_for(file)) out.insert(out.end(), {"-iquote", folder.string()});
  for (const fs::path& folder : include) out.insert(out.end(), {"-I", folder.string()});
  for (const std::string& macro : define) out.insert(out.end(), {"-D", macro});
  return out;
}

bool ReadProgram::says(std::string_view word) const {
  return std::ranges::any_of(files, [&](const File& file) { return file.text.find(word) != std::string::npos; });
}

}  // namespace arkmesh::sim_ode
