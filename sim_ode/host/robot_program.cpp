// Compiles into a directory that is gone before load() returns: also a killed process leaves nothing behind.
#include "sim_ode/host/robot_program.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "sim_ode/host/subprocess.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// Of a robot's static memory; text buffers of programs for PCs were seen to take 11 kB.
constexpr std::size_t max_memory_bytes = 256 << 10;

// A directory of our own below the system's temporary one; removed with everything in it.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::error_code error;
    fs::path base = fs::temp_directory_path(error);
    if (error) base = "/tmp";
    std::string name = (base / "arkmesh-controller-XXXXXX").string();
    if (!mkdtemp(name.data()))
      throw ProgramError(
          fmt::format("no directory can be made in {} to compile in; free some space or set TMPDIR", base.string()));
    path_ = name;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// Where kilolib.h lies: beside an installed program, or among the sources.
fs::path find_kilolib() {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / "share" / "arkmesh" / "kilolib";
  if (fs::exists(installed / "robot.c", ignored)) return installed;
  const fs::path source = fs::path(ARKMESH_SOURCE_DIR) / "sim_ode" / "kilolib";
  if (fs::exists(source / "robot.c", ignored)) return source;
  throw ProgramError(fmt::format("the Kilobot library is neither in {} nor in {}; install arkmesh again",
                                 source.string(), installed.string()));
}

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  const bool empty = in && in.peek() == std::ifstream::traits_type::eof();
  if (!fs::is_regular_file(file) || !(empty || (in && text << in.rdbuf())))
    throw ProgramError(fmt::format("{} cannot be read; name a C file", file.string()));
  // some editors put a mark of three bytes before the first line
  std::string read = text.str();
  if (read.starts_with("\xEF\xBB\xBF")) read.erase(0, 3);
  return read;
}

// The line that says what is wrong; otherwise the compiler's first one. Without the path of our own folder. An error in
// one of our macros is told where the program uses it.
std::string first_error(std::string output, const fs::path& folder, const fs::path& kilolib) {
  const std::string ours = folder.string() + "/";
  for (std::size_t at; (at = output.find(ours)) != std::string::npos;) output.erase(at, ours.size());
  // what the compiler says before the words of our headers' own refusals
  constexpr std::string_view preface = "declared with attribute error: ";
  for (std::size_t at; (at = output.find(preface)) != std::string::npos;) {
    const std::size_t begin = output.rfind("call to ", at);
    output.erase(begin == std::string::npos ? at : begin,
                 begin == std::string::npos ? preface.size() : at + preface.size() - begin);
  }
  std::string first, of_macro;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    if (first.empty()) first = line;
    if (!of_macro.empty()) {
      const auto note = line.find(" note: in expansion of macro");
      if (note == std::string::npos) return of_macro;
      if (!line.starts_with(kilolib.string())) return line.substr(0, note) + of_macro.substr(of_macro.find(" error:"));
      continue;
    }
    for (const char* mark : {"error:", "undefined reference", "multiple definition"})
      if (line.find(mark) != std::string::npos) {
        if (!line.starts_with(kilolib.string()) || line.find(" error:") == std::string::npos) return line;
        of_macro = line;
        break;
      }
  }
  if (!of_macro.empty()) return of_macro;
  return first.empty() ? "the compiler gave no message" : first;
}

// Whether a variable of the program or of what it includes may change under its eyes: the word stands in lines that are
// neither the system's nor our library's. `preprocessed` has line markers.
bool waits_for_memory(const std::string& preprocessed, const fs::path& kilolib) {
  const std::string ours = "\"" + kilolib.string() + "/";
  std::istringstream lines(preprocessed);
  bool of_program = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# ")) {
      // # 17 "/usr/include/stdio.h" 1 3 4: the flags behind the name; 3 is the system's
      const std::string flags = line.substr(line.rfind('"') + 1) + " ";
      of_program = line.find(ours) == std::string::npos && flags.find(" 3 ") == std::string::npos;
    } else if (of_program && line.find("volatile") != std::string::npos)
      return true;
  }
  return false;
}

// Makes a shared object of a program and our library, in a folder of its own.
class ObjectBuild {
 public:
  // `source` is the program's file, `text` what it says. Throws ProgramError.
  ObjectBuild(const fs::path& source, const std::string& text, const fs::path& work)
      : text_(text),
        work_(work),
        folder_(fs::absolute(source).parent_path()),
        kilolib_(kilolib_folder()),
        copy_(work / (source.extension() == ".c" ? source.filename() : fs::path("program.c"))),
        object_(work / "program.so") {
    if (!(std::ofstream(copy_, std::ios::binary) << "#line 1 \"" << source.string() << "\"\n" << text << "\n"))
      throw ProgramError(fmt::format("{} cannot be written; free some space or set TMPDIR", copy_.string()));
  }

  // The object's file. Throws ProgramError with the compiler's first error.
  const fs::path& run() {
    try {
      const fs::path expanded = work_ / "expanded.i";
      compile({"-E", copy_.string(), "-o", expanded.string()});
      if (waits_for_memory(read_text(expanded), kilolib_))
        build_counted();
      else
        link(copy_);
    } catch (const ProgramError&) {
      // Perhaps because our kilo_ticks is a macro: as a field's name, or declared anew. A variable is as good when its
      // readings are counted.
      if (text_.find("kilo_ticks") == std::string::npos || !builds_with_plain_clock()) throw;
    }
    return object_;
  }

 private:
  // What a robot's compiler is told, as far as a PC can follow, and one exchangeable section (robot.ld). Hidden symbols
  // keep a program's `send` or `time` from being taken for the C library's; __STRICT_ANSI__ keeps that library's
  // headers to the standard, so that they leave names like `y0` or `index` to programs. No sibling calls, so that a
  // fault's line is the one that called.
  std::vector<std::string> language() const {
    return {"cc",
            "-std=gnu11",
            "-fgnu89-inline",
            "-O2",
            "-g",
            "-w",
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
            "-fno-optimize-sibling-calls",
            "-ffp-contract=off",
            "-fno-diagnostics-show-caret",
            "-fno-stack-protector",
            "-fstack-clash-protection",
            "-D__NO_INLINE__",
            "-D__STRICT_ANSI__",
            "-DF_CPU=8000000UL",
            "-iquote",
            kilolib_.string(),
            "-iquote",
            folder_.string(),
            "-I",
            kilolib_.string(),
            "-I",
            folder_.string(),
            "-include",
            (kilolib_ / "kilolib.h").string()};
  }

  void compile(const std::vector<std::string>& more) const {
    std::vector<std::string> command = language();
    command.insert(command.end(), more.begin(), more.end());
    if (plain_clock_) command.push_back("-DARKMESH_PLAIN_CLOCK");
    const Finished done = run_to_end(command);
    if (done.status == 127 || (done.status == -1 && done.output.empty()))
      throw ProgramError("the C compiler `cc` cannot be started; install gcc");
    if (done.status != 0) throw ProgramError("does not compile: " + first_error(done.output, work_, kilolib_));
  }

  void link(const fs::path& part) const {
    compile({"-shared", "-nostartfiles", "-Wl,-Bsymbolic,-z,now,-z,defs", "-Wl,-T," + (kilolib_ / "robot.ld").string(),
             part.string(), (kilolib_ / "robot.c").string(), (kilolib_ / "avr_libc.c").string(),
             (kilolib_ / "robot_math.c").string(), "-lm", "-o", object_.string()});
  }

  // A program that may wait for a variable which a callback changes has its accesses to memory counted, so that waiting
  // takes time.
  void build_counted() const {
    const fs::path part = work_ / "program.o";
    compile({"-fsanitize=thread", "--param", "tsan-distinguish-volatile=1", "--param",
             "tsan-instrument-func-entry-exit=0", "-c", copy_.string(), "-o", part.string()});
    link(part);
  }

  bool builds_with_plain_clock() {
    plain_clock_ = true;
    try {
      build_counted();
      return true;
    } catch (const ProgramError&) {
      return false;
    }
  }

  const std::string& text_;
  const fs::path work_, folder_, kilolib_;
  const fs::path
      copy_;  // in an empty folder: a quoted include then finds our headers before old ones beside the program
  const fs::path object_;
  bool plain_clock_ = false;
};

std::map<std::pair<std::string, std::string>, std::weak_ptr<const RobotProgram>>& loaded_programs() {
  static std::map<std::pair<std::string, std::string>, std::weak_ptr<const RobotProgram>> programs;
  return programs;
}

}  // namespace

fs::path kilolib_folder() {
  return find_kilolib();
}

std::shared_ptr<const RobotProgram> RobotProgram::load(const fs::path& source) {
  const std::string text = read_text(source);
  std::erase_if(loaded_programs(), [](const auto& entry) { return entry.second.expired(); });
  const auto key = std::pair(fs::absolute(source).string(), text);
  if (const auto found = loaded_programs().find(key); found != loaded_programs().end())
    if (auto program = found->second.lock()) return program;

  std::shared_ptr<RobotProgram> program(new RobotProgram);
  program->source_ = source;
  const TemporaryDirectory work;
  program->load_object(ObjectBuild(source, text, work.path()).run());
  loaded_programs()[key] = program;
  return program;
}

void RobotProgram::load_object(const fs::path& object) {
  file_ = open(object.c_str(), O_RDONLY | O_CLOEXEC);
  handle_ = dlopen(object.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle_) throw ProgramError(fmt::format("does not load: {}", dlerror()));
  abi_ = static_cast<const arkmesh_program*>(dlsym(handle_, "arkmesh_program"));
  if (!abi_) throw ProgramError("does not load: it lacks the simulator's part");

  // behind a robot's memory: a page to read, then one to be caught at
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  char* const end = abi_->end;
  if (reinterpret_cast<std::uintptr_t>(end) % page != 0 || mprotect(end, page, PROT_READ) != 0 ||
      mprotect(end + page, page, PROT_NONE) != 0)
    throw ProgramError("does not load: its memory cannot be fenced");

  if (const auto bytes = static_cast<std::size_t>(end - abi_->begin); bytes > max_memory_bytes)
    throw ProgramError(
        fmt::format("its variables take {} bytes; a robot has 2048, and the simulator gives it at most {}", bytes,
                    max_memory_bytes));
  const auto* begin = reinterpret_cast<const std::byte*>(abi_->begin);
  first_.assign(begin, begin + (end - abi_->begin));
}

void RobotProgram::listen() const {
  if (!text_) text_ = std::make_unique<ProgramText>();
}

RobotProgram::~RobotProgram() {
  if (handle_) dlclose(handle_);
  if (file_ >= 0) close(file_);
}

std::string RobotProgram::place_of(const void* instruction) const {
  Dl_info where{};
  if (file_ < 0 || !dladdr(instruction, &where) || !where.dli_fbase) return {};
  Dl_info ours{};
  dladdr(abi_, &ours);
  if (where.dli_fbase != ours.dli_fbase) return {};
  const auto offset = reinterpret_cast<std::uintptr_t>(instruction) - reinterpret_cast<std::uintptr_t>(where.dli_fbase);
  const Finished found = run_to_end(
      {"addr2line", "-f", "-s", "-e", fmt::format("/proc/{}/fd/{}", getpid(), file_), fmt::format("{:#x}", offset)});
  std::istringstream lines(found.output);
  std::string function, line;
  if (found.status != 0 || !std::getline(lines, function) || !std::getline(lines, line) || line.starts_with("??"))
    return {};
  if (const auto extra = line.find(" (disc"); extra != std::string::npos) line.resize(extra);
  return fmt::format(" in {} ({})", function, line);
}

}  // namespace arkmesh::sim_ode
