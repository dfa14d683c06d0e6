#include "sim_ode/host/programs/object_build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "hal/child_process.hpp"
#include "hal/files/own_files.hpp"
#include "sim_ode/host/programs/program_inputs.hpp"
#include "sim_ode/host/programs/robot_types.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// One of arkmesh's folders, by a file that is in it: beside an installed program, or among the sources.
fs::path find_folder(const fs::path& name, const fs::path& among_sources, const char* file, const char* what) {
  const fs::path found = hal::own_file(name / file, among_sources / file);
  std::error_code ignored;
  if (fs::exists(found, ignored)) return found.parent_path();
  throw ProgramError(fmt::format("{} is not in {}; install arkmesh again", what, found.parent_path().string()));
}

// Whether a path lies in a folder of arkmesh, and not of the program.
bool is_ours(std::string_view path) {
  for (const fs::path& folder : {kilolib_folder(), firmware_folder()})
    if (path.starts_with(folder.string() + "/")) return true;
  return false;
}

// The line that says what is wrong; otherwise the compiler's first one. Without the path of our own folder. An error in
// one of our macros is told where the program uses it.
std::string first_error(std::string output, const fs::path& folder) {
  const std::string ours = folder.string() + "/";
  for (std::size_t at; (at = output.find(ours)) != std::string::npos;) output.erase(at, ours.size());
  // "a.c:3:(.text+0xc): undefined reference": binutils 2.44 tells the place in the object, too
  for (std::size_t at; (at = output.find(":(.")) != std::string::npos && output.find("):", at) != std::string::npos;)
    output.erase(at, output.find("):", at) + 1 - at);
  // what the compiler says before the words of our headers' own refusals
  constexpr std::string_view preface = "declared with attribute error: ";
  for (std::size_t at; (at = output.find(preface)) != std::string::npos;) {
    const std::size_t begin = output.rfind("call to ", at);
    output.erase(begin == std::string::npos ? at : begin,
                 begin == std::string::npos ? preface.size() : at + preface.size() - begin);
  }
  // of registers that can be read (avr/io.h)
  constexpr std::string_view place = "arkmesh_register_";
  for (std::size_t at; (at = output.find(place)) != std::string::npos;) {
    const std::size_t begin = output.rfind("error: ", at), end = output.find('\n', at);
    const std::string name = output.substr(at + place.size(), output.find('(', at) - at - place.size());
    output.replace(
        begin + 7, end - begin - 7,
        fmt::format("a simulated robot's register {} can only be read; use the functions of kilolib.h", name));
  }
  std::string first, of_macro;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (first.empty()) first = line;
    if (!of_macro.empty()) {
      const auto note = line.find(" note: in expansion of macro");
      if (note == std::string::npos) return of_macro;
      if (!is_ours(line)) return line.substr(0, note) + of_macro.substr(of_macro.find(" error:"));
      continue;
    }
    for (const char* mark : {"error:", "undefined reference", "multiple definition"})
      if (line.find(mark) != std::string::npos) {
        if (!is_ours(line) || line.find(" error:") == std::string::npos) return line;
        of_macro = line;
        break;
      }
  }
  if (!of_macro.empty()) return of_macro;
  return first.empty() ? "the compiler gave no message" : first;
}

// Whether a variable of the program or of what it includes may change under its eyes: the word stands in lines that are
// neither the system's nor ours. `preprocessed` has line markers.
bool names_volatile(const std::string& preprocessed) {
  std::istringstream lines(preprocessed);
  bool of_program = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# "))
      of_program = program_follows(line, kilolib_folder()) && program_follows(line, firmware_folder());
    else if (of_program && line.find("volatile") != std::string::npos)
      return true;
  }
  return false;
}

// The files in line markers, `# 17 "prog.c"`.
std::vector<std::string> files_in(const std::string& preprocessed) {
  std::vector<std::string> out;
  std::istringstream lines(preprocessed);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find('"'), end = line.rfind('"');
    if (line.starts_with("# ") && begin < end && end != std::string::npos)
      out.push_back(line.substr(begin + 1, end - begin - 1));
  }
  return out;
}

// What a robot's compiler is told, as far as a PC can follow, and one exchangeable section (robot.ld). Hidden symbols
// keep a program's `send` or `time` from being taken for the C library's; __STRICT_ANSI__ keeps that library's
// headers to the standard, so that they leave names like `y0` or `index` to programs. No sibling calls, so that a
// fault's line is the one that called. From gcc 14 on only -fpermissive lets old C pass; before, gcc ignores it.
// `source`: the file of the program that is compiled.
std::vector<std::string> language(const ReadProgram& program, const fs::path& source, const fs::path& kilolib,
                                  const fs::path& firmware) {
  std::vector<std::string> words = {"cc",
                                    "-std=gnu11",
                                    "-fgnu89-inline",
                                    "-O2",
                                    "-g",
                                    "-w",
                                    "-fpermissive",
                                    "-fPIC",
                                    "-fvisibility=hidden",
                                    "-fcommon",
                                    "-funsigned-char",
                                    "-funsigned-bitfields",
                                    "-fshort-enums",
                                    "-fpack-struct",
                                    "-fwrapv",
                                    "-fno-strict-aliasing",
                                    "-fno-builtin-printf",
                                    "-fno-builtin-malloc",
                                    "-fno-builtin-calloc",
                                    "-fno-builtin-realloc",
                                    "-fno-builtin-free",
                                    "-fno-optimize-sibling-calls",
                                    "-ffp-contract=off",
                                    "-fno-diagnostics-show-caret",
                                    "-fno-stack-protector",
                                    "-fstack-clash-protection",
                                    "-D__NO_INLINE__",
                                    "-D__STRICT_ANSI__",
                                    "-DF_CPU=8000000UL",
                                    "-include",
                                    (kilolib / "kilolib.h").string()};
  std::vector<fs::path> folders{kilolib, firmware};
  std::ranges::move(program.folders_for(source), std::back_inserter(folders));
  for (const char* option : {"-iquote", "-I"})
    for (const fs::path& folder : folders) words.insert(words.end(), {option, folder.string()});
  for (const std::string& macro : program.define) words.insert(words.end(), {"-D", macro});
  return words;
}

// A program that may wait for a variable which a callback changes has its accesses to memory counted, so that waiting
// takes time.
const std::vector<std::string> counting_options = {"-fsanitize=thread", "--param", "tsan-distinguish-volatile=1",
                                                   "--param", "tsan-instrument-func-entry-exit=0"};
constexpr const char* plain_clock_option = "-DARKMESH_PLAIN_CLOCK";

// As a C string.
std::string c_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c == '\n' ? ' ' : c);
  return out + "\"";
}

std::vector<fs::path> library_sources(const fs::path& kilolib) {
  return {kilolib / "robot.c", kilolib / "avr_libc.c", kilolib / "robot_math.c"};
}

std::vector<std::string> link_options(const fs::path& kilolib) {
  std::vector<std::string> words = {"-shared", "-nostartfiles", "-Wl,-Bsymbolic,-z,now,-z,defs",
                                    "-Wl,-T," + (kilolib / "robot.ld").string()};
  for (const fs::path& source : library_sources(kilolib)) words.push_back(source.string());
  words.push_back("-lm");
  return words;
}

// The compiler had no time left.
class TooLong : public ProgramError {
 public:
  using ProgramError::ProgramError;
};

}  // namespace

std::string lies_elsewhere(const ReadProgram& program, const std::string& sentence) {
  const fs::path own = fs::absolute(program.files.front().path).parent_path();
  std::error_code error;
  if (const std::size_t end = sentence.find(": No such file or directory"); end != std::string::npos) {
    const fs::path header = sentence.substr(sentence.rfind(' ', end) + 1, end - sentence.rfind(' ', end) - 1);
    int left = 2000;  // entries to look at
    for (fs::recursive_directory_iterator in(own.parent_path(), error), end_of_all;
         !error && in != end_of_all && left-- > 0; in.increment(error))
      if (in->path().filename() == header.filename() && in->path().string().ends_with("/" + header.string())) {
        const std::string path = in->path().string();
        return fmt::format("; it lies in {0}: name that folder, with -I or `include`",
                           path.substr(0, path.size() - header.string().size() - 1));
      }
    return {};
  }
  if (sentence.find("multiple definition of") != std::string::npos) return "; name the files of one program";
  if (program.files.front().path.extension() != ".c" && sentence.find("error: ") != std::string::npos)
    return "; robots' programs are compiled as C, whatever they are called";
  constexpr std::string_view missing = "undefined reference to `";
  const std::size_t at = sentence.find(missing);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + missing.size();
  const std::string name = sentence.substr(begin, sentence.find('\'', begin) - begin);
  if (!wrong_with_macro(name).empty()) return {};
  const std::regex definition("\\b" + name + R"(\s*\([^;{}()]*\)\s*\{)");
  for (fs::directory_iterator in(own, error), end; !error && in != end; in.increment(error)) {
    const auto same = [&](const ReadProgram::File& file) {
      return one_spelling(file.path) == one_spelling(in->path());
    };
    if (in->path().extension() != ".c" || std::ranges::any_of(program.files, same)) continue;
    const std::string text = read_source(in->path());
    if (std::regex_search(text, definition))
      return fmt::format("; `{}` stands in {} beside it: give both, or the folder", name,
                         in->path().filename().string());
  }
  return {};
}

fs::path kilolib_folder() {
  return find_folder("kilolib", fs::path("sim_ode") / "kilolib", "robot.c", "the Kilobot library");
}

fs::path firmware_folder() {
  return find_folder("firmware", fs::path("hal") / "platforms" / "kilobot" / "firmware", "arkmesh_id.h",
                     "the robots' firmware");
}

ObjectBuild::ObjectBuild(const ReadProgram& program, const fs::path& work, CompilerLimits limits)
    : program_(program),
      work_(work),
      kilolib_(kilolib_folder()),
      firmware_(firmware_folder()),
      object_(work / "program.so"),
      deadline_(std::chrono::steady_clock::now() + limits.time),
      limits_(limits) {
  for (std::size_t i = 0; i < program.files.size(); ++i) {
    const auto& [source, text] = program.files[i];
    const fs::path folder = work / fmt::format("{}", i);
    const Part& part = parts_.emplace_back(
        Part{source, folder / (source.extension() == ".c" ? source.filename() : fs::path("program.c")),
             folder / "expanded.i", folder / "typed.i", folder / "part.o"});
    std::error_code error;
    fs::create_directory(folder, error);
    if (!(std::ofstream(part.copy, std::ios::binary) << "#line 1 \"" << source.string() << "\"\n" << text << "\n"))
      throw ProgramError(fmt::format("{} cannot be written; free some space or set TMPDIR", part.copy.string()));
  }
}

// With a robot's types first; with a PC's when that does not compile. Each perhaps because our kilo_ticks is a macro:
// as a field's name, or declared anew. A variable is as good when its readings are counted. Or because another
// simulator's header brings what this program has not included.
void ObjectBuild::run() {
  const bool asks_for_pc_types = std::ranges::any_of(
      program_.define, [](const std::string& macro) { return macro.starts_with("ARKMESH_PC_TYPES"); });
  std::string of_robot_types = asks_for_pc_types ? "was not tried" : "", of_pc_types;
  for (const auto& [pc_types, plain_clock, more_headers] :
       std::initializer_list<std::array<bool, 3>>{{false, false, false},
                                                  {false, true, false},
                                                  {false, false, true},
                                                  {true, false, false},
                                                  {true, true, false},
                                                  {true, false, true}}) {
    if (plain_clock && !program_.says("kilo_ticks")) continue;
    if (!pc_types && asks_for_pc_types) continue;
    if (more_headers && of_robot_types.find("undeclared") == std::string::npos &&
        of_robot_types.find("unknown type name") == std::string::npos)
      continue;
    plain_clock_ = plain_clock;
    more_headers_ = more_headers;
    if (pc_types) pc_types_option_ = "-DARKMESH_PC_TYPES=" + c_string(of_robot_types);
    try {
      if ((!pc_types || asks_for_pc_types) && !std::exchange(is_expanded_, false)) expand();
      build(waits_for_memory_ || plain_clock ? counting_options : std::vector<std::string>());
      return;
    } catch (const TooLong&) {
      throw;
    } catch (const ProgramError& error) {
      std::string& first = pc_types ? of_pc_types : of_robot_types;
      if (first.empty()) first = error.what();
    }
  }
  throw ProgramError(of_pc_types + lies_elsewhere(program_, of_pc_types));
}

std::vector<std::string> ObjectBuild::decided_by() {
  // of the order of steps in run(), which no option shows: to be counted up when it changes
  std::vector<std::string> all = {"6"};
  for (const auto& [source, text] : program_.files) {
    all.insert(all.end(), {source.string(), text});
    std::ranges::move(language(program_, source, kilolib_, firmware_), std::back_inserter(all));
  }
  for (const auto& part : {counting_options, {plain_clock_option}, link_options(kilolib_)})
    all.insert(all.end(), part.begin(), part.end());
  try {
    expand();
  } catch (const ProgramError&) {
    return {};
  }
  is_expanded_ = true;
  std::set<std::string> read;
  for (const Part& part : parts_) {
    std::string text = read_source(part.expanded);
    for (const std::string& file : files_in(text))
      if (!file.starts_with(work_.string())) read.insert(file);
    for (std::size_t at; (at = text.find(work_.string())) != std::string::npos;) text.erase(at, work_.string().size());
    all.push_back(std::move(text));
  }
  for (const fs::path& folder : {kilolib_, firmware_})
    for (const auto& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied))
      if (entry.is_regular_file()) read.insert(entry.path().string());
  for (const std::string& file : read) all.insert(all.end(), {file, content_of(file)});
  // they stand for the moment of compiling, or for a file that only the assembler reads
  for (const std::string& text : all)
    for (const char* word : {"__DATE__", "__TIME__", "__TIMESTAMP__", "incbin"})
      if (text.find(word) != std::string::npos) return {};
  return all;
}

void ObjectBuild::compile(const fs::path& source, const std::vector<std::string>& more) const {
  std::vector<std::string> command = {"env", "TMPDIR=" + work_.string()};  // what a killed compiler leaves is there
  for (const auto& part : {language(program_, source, kilolib_, firmware_), more})
    command.insert(command.end(), part.begin(), part.end());
  if (plain_clock_) command.push_back(plain_clock_option);
  if (more_headers_)
    for (const char* header : {"stdio.h", "stdlib.h", "string.h"}) command.insert(command.end(), {"-include", header});
  if (!pc_types_option_.empty()) command.push_back(pc_types_option_);
  const hal::Finished done = hal::run_to_end(
      {.command = command, .processor_time = limits_.work},
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now()));
  if (done.too_long ||
      done.output.find("CPU time limit exceeded signal terminated program") != std::string::npos)  // gcc of its parts
    throw TooLong("does not compile: the C compiler `cc` was ended because it had not finished after " +
                  limits_.text());
  if (done.status == 127) throw ProgramError("the C compiler `cc` cannot be started; apt-get install gcc libc6-dev");
  if (done.status != 0) throw ProgramError("does not compile: " + first_error(with_own_names(done.output), work_));
}

// The compiler's words with the user's files in place of our copies.
std::string ObjectBuild::with_own_names(std::string output) const {
  for (const Part& part : parts_)
    for (const std::string& ours : {part.copy.string(), part.typed.string(), part.object.string()})
      for (std::size_t at = 0; (at = output.find(ours, at)) != std::string::npos; at += part.source.string().size())
        output.replace(at, ours.size(), part.source.string());
  return output;
}

// Finds out what decides how the files are compiled: whether one waits for a variable, which may be another file's, and
// which are parts of others.
void ObjectBuild::expand() {
  std::vector<fs::path> files;
  std::vector<std::vector<std::string>> read;
  for (const Part& part : parts_) {
    compile(part.source, {"-E", part.copy.string(), "-o", part.expanded.string()});
    const std::string text = read_source(part.expanded);
    waits_for_memory_ = waits_for_memory_ || names_volatile(text);
    files.push_back(part.source);
    read.push_back(files_in(text));
  }
  const std::vector<bool> included = included_by_others(files, read);
  std::vector<Part> alone;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (!included[i]) alone.push_back(parts_[i]);
  if (!alone.empty()) parts_ = std::move(alone);
}

// A program of one file that needs no options of its own is compiled and linked at once, which takes less time.
void ObjectBuild::build(const std::vector<std::string>& options) const {
  const bool at_once = parts_.size() == 1 && options.empty();
  std::vector<std::string> words;
  for (const Part& part : parts_) {
    const fs::path& source = pc_types_option_.empty() ? part.typed : part.copy;
    if (pc_types_option_.empty() &&
        !(std::ofstream(part.typed, std::ios::binary) << with_robot_types(read_source(part.expanded), kilolib_)))
      throw ProgramError(fmt::format("{} cannot be written; free some space or set TMPDIR", part.typed.string()));
    words.push_back((at_once ? source : part.object).string());
    if (at_once) continue;
    std::vector<std::string> of_part = options;
    of_part.insert(of_part.end(), {"-c", source.string(), "-o", part.object.string()});
    compile(part.source, of_part);
  }
  words.insert(words.end(), {"-o", object_.string()});
  std::ranges::move(link_options(kilolib_), std::back_inserter(words));
  compile(parts_.front().source, words);
}

}  // namespace arkmesh::sim_ode
