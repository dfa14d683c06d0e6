// Makes a shared object of a Kilobot C program and our library, with the C compiler `cc`. Keeps nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace arkmesh::sim_ode {

// The program does not compile, link or load: one sentence with the compiler's first error.
class ProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Where kilolib.h and the rest of what programs are compiled against lie: beside the sources, or beside an installed
// arkmesh. Throws ProgramError.
std::filesystem::path kilolib_folder();
// Likewise arkmesh_id.h and the programs of the set-up procedures, which real robots run as simulated ones do.
std::filesystem::path firmware_folder();

// What a program's file says. Throws ProgramError.
std::string read_program(const std::filesystem::path& file);

class ObjectBuild {
 public:
  // The compiler's, for all that it does. A program takes 0.3 s; on a busy machine a long one takes a few seconds.
  static constexpr std::chrono::seconds time_limit{60};

  // `source` is the program's file, `text` what it says, `work` an empty folder. Throws ProgramError.
  ObjectBuild(const std::filesystem::path& source, const std::string& text, const std::filesystem::path& work,
              std::chrono::milliseconds limit = time_limit);

  // Makes the object. Throws ProgramError with the compiler's first error.
  void run();

  // All that the compiler is told, but for the program's text and the names of temporary files.
  static std::vector<std::string> recipe(const std::filesystem::path& source);
  // In `work`: the object's file, and rules that name all headers that were read, as compilers write them for make; the
  // latter is missing where the folder's name has blanks.
  const std::filesystem::path& object() const { return object_; }
  std::filesystem::path rules() const { return work_ / "read.d"; }
  // The C files: the program's copy and the library's.
  std::vector<std::filesystem::path> compiled() const;
  const std::filesystem::path& work() const { return work_; }

 private:
  void compile(const std::vector<std::string>& more) const;
  void link(const std::filesystem::path& part) const;
  void build_counted() const;
  bool builds_with_plain_clock();

  const std::string& text_;
  const std::filesystem::path source_, work_, kilolib_, firmware_;
  // in an empty folder: a quoted include then finds our headers before old ones beside the program
  const std::filesystem::path copy_;
  const std::filesystem::path object_;
  const std::chrono::steady_clock::time_point deadline_;
  const std::chrono::milliseconds limit_;
  bool plain_clock_ = false;
};

}  // namespace arkmesh::sim_ode
