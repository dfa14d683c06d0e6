#include "sim_ode/host/programs/program_inputs.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace arkmesh::sim_ode {
namespace {

std::size_t skip_blanks(std::string_view text, std::size_t at) {
  while (at < text.size() && (text[at] == ' ' || text[at] == '\t' || text[at] == '(')) ++at;
  return at;
}

}  // namespace

std::string content_of(const std::filesystem::path& file) {
  const int in = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (in < 0) return {};
  struct stat about {};
  std::string out;
  if (fstat(in, &about) == 0 && S_ISREG(about.st_mode)) out.resize(static_cast<std::size_t>(about.st_size));
  std::size_t got = 0;
  for (ssize_t n; got < out.size() && (n = read(in, out.data() + got, out.size() - got)) > 0;)
    got += static_cast<std::size_t>(n);
  out.resize(got);
  close(in);
  return out;
}

std::vector<std::string> paths_in_rules(const std::string& rules) {
  std::vector<std::string> paths;
  std::string word;
  const auto end_word = [&] {
    // a target ends in a colon
    if (!word.empty() && word.back() != ':') paths.push_back(word);
    word.clear();
  };
  for (std::size_t at = 0; at < rules.size(); ++at) {
    const char c = rules[at], next = at + 1 < rules.size() ? rules[at + 1] : '\n';
    if (c == '\\' && (next == ' ' || next == '#' || next == '\\')) {
      word += next;
      ++at;
    } else if (c == '\\' && next == '\n') {
      ++at;
      end_word();
    } else if (c == '$' && next == '$') {
      word += '$';
      ++at;
    } else if (std::isspace(static_cast<unsigned char>(c))) {
      end_word();
    } else {
      word += c;
    }
  }
  end_word();
  return paths;
}

std::vector<std::string> names_included(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0; (at = text.find("include", at)) != std::string::npos;) {
    at += std::string_view("include").size();
    if (std::string_view(text).substr(at).starts_with("_next")) at += std::string_view("_next").size();
    const std::size_t open = skip_blanks(text, at);
    if (open >= text.size() || (text[open] != '"' && text[open] != '<')) continue;
    const std::size_t close = text.find_first_of(text[open] == '"' ? "\"\n" : ">\n", open + 1);
    if (close == std::string::npos || text[close] == '\n' || close == open + 1) continue;
    names.push_back(text.substr(open + 1, close - open - 1));
    at = close;
  }
  return names;
}

std::vector<std::filesystem::path> files_with_headers(const ProgramSources& program) {
  std::vector<std::filesystem::path> out = files_of(program), folders = program.include;
  for (const std::filesystem::path& file : out) folders.push_back(file.parent_path());
  std::string macros;  // whose value may be a header's name
  for (const std::string& macro : program.define) macros += "include " + macro.substr(macro.find('=') + 1) + "\n";
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::vector<std::filesystem::path> places = folders;
    places.push_back(out[i].parent_path());
    for (const std::string& included : names_included(content_of(out[i]) + "\n" + macros))
      for (const std::filesystem::path& place : places) {
        const std::filesystem::path file = std::filesystem::absolute(place / included).lexically_normal();
        std::error_code ignored;
        if (std::filesystem::is_regular_file(file, ignored) && std::ranges::find(out, file) == out.end())
          out.push_back(file);
      }
  }
  return out;
}

}  // namespace arkmesh::sim_ode
