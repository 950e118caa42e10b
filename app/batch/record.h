// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/batch/manifest.h"

/// What the output folder remembers of each scan, one small file per scan below
/// OUTPUT_ROOT/.nacre/: records/NAME.json of a scan that was encoded, failures/NAME.json of one
/// that was not. Each is replaced whole, by rename, so no two processes ever write into one file.
namespace nacre::app::batch {

/// Size and time of a file: unequal means that its bytes may have changed.
struct FileStamp {
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0;

  bool operator==(const FileStamp&) const = default;
};
[[nodiscard]] std::optional<FileStamp> stamp_of(const std::filesystem::path& file);

/// A scan that was encoded. Figures are those of encode's report, none if it had none.
struct Record {
  std::string key;  ///< content_key() of what made the output
  FileStamp input;
  std::string input_hash, output_hash;  ///< hash.h
  std::uint64_t output_bytes = 0;
  std::uint64_t vertices = 0, faces = 0;  ///< of the input
  std::optional<double> psnr_db, max_error, max_error_percent, bits_per_input_vertex;
  std::vector<std::pair<std::string, std::uint64_t>> cleaning;  ///< kind of change, count
  std::uint64_t fallbacks = 0;  ///< pieces that were not remeshed as usual
  // From here on, what may differ between two runs that make the same output.
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak_bytes = 0;
  int threads = 0;
  std::string host;
  std::string thumbnail;  ///< PNG in base64; empty: none
};

/// A scan that was not.
struct Failure {
  std::string key;  ///< failure_key() of the attempts; others do not count
  int attempts = 0;
  bool final = false;  ///< not to be tried again
  int exit_code = 0;   ///< as nacre encode left; 128 + signal if it was killed, as shells say
  int signal = 0;
  std::string message;  ///< one line
};

/// The name for equal outputs: hash of the input's bytes, the options and the codec's version.
[[nodiscard]] std::string content_key(const std::string& input_hash,
                                      const std::vector<std::string>& options);

/// The same for attempts, which must not read the input to know: its stamp in the place of its
/// hash.
[[nodiscard]] std::string failure_key(const FileStamp& input,
                                      const std::vector<std::string>& options);

/// The version that both keys hold.
[[nodiscard]] std::string codec_version();

/// Gives a finished file its name, whose folder is made if missing; lasts through a power cut.
/// Errors   kCannotWrite.
[[nodiscard]] Result<void> put_in_place(const std::filesystem::path& from,
                                        const std::filesystem::path& to);

/// The files of one output root.
class Store {
 public:
  explicit Store(std::filesystem::path output_root);

  [[nodiscard]] std::filesystem::path folder() const { return folder_; }  ///< .nacre
  [[nodiscard]] std::filesystem::path work() const { return folder_ / "work"; }
  [[nodiscard]] std::filesystem::path report_path(const Item& item) const;

  /// None if there is none, or if it does not read: it is then as if it had never been written.
  [[nodiscard]] std::optional<Record> record(const Item& item) const;
  [[nodiscard]] std::optional<Failure> failure(const Item& item) const;
  /// Whether a batch made this output, or was about to: there is a record, readable or not.
  [[nodiscard]] bool knows(const Item& item) const;

  /// Written in `work`, a folder of the same file system, and moved; folders are made as needed. On
  /// the disk when this returns. Errors   kCannotWrite.
  [[nodiscard]] Result<void> write(const Item& item, const Record& record,
                                   const std::filesystem::path& work) const;
  [[nodiscard]] Result<void> write(const Item& item, const Failure& failure,
                                   const std::filesystem::path& work) const;
  void forget_failure(const Item& item) const;

 private:
  std::filesystem::path output_root_, folder_;
};

/// How an item stands.
enum class State : std::uint8_t {
  kDone,     ///< the output is there, whole, and made of this input by these options
  kToDo,     ///< not made yet, or of another input, other options, another version
  kForeign,  ///< a file with the output's name is there that no batch made
  kFailed,   ///< tried and given up
};

/// Reads records and the output, which is small. The input is read only if `verify`, or if its
/// stamp is not the recorded one and `read_changed`; without, such an item is to do.
[[nodiscard]] State state_of(const Store& store, const Manifest& manifest, const Item& item,
                             bool verify, bool read_changed);

}  // namespace nacre::app::batch
