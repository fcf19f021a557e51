// What the files and command lines for farm engines have in common: quoting, titles, the command lines of tasks.

#pragma once

#include "batch/farm/farm_job.h"

#include <cstdint>
#include <string>
#include <vector>

namespace betamesh {

/// Words quoted so that a shell reads them back unchanged.
std::string shellWords(const std::vector<std::string>& words);

/// The command line, run in the folder of the job, because farms start tasks in folders of their own.
std::vector<std::string> inFolder(const FarmJob& job, const std::vector<std::string>& words,
                                  const std::vector<std::string>& more_words = {});

/// The command line of the report with the frames that it expects. in: a job with a report.
std::vector<std::string> reportWords(const FarmJob& job);

std::vector<int> allFrames(const FarmJob& job);

/// The number of frames in the largest chunk, at least 1.
std::size_t largestChunk(const FarmJob& job);

/// Bytes in mebibytes, rounded up.
std::uint64_t mebibytes(std::uint64_t bytes);

/// A name for people: control characters become spaces.
std::string titleOf(std::string name);

/// A name of at most `longest` bytes, cut between characters of UTF-8.
std::string shortened(const std::string& name, std::size_t longest);

/// errors  a word with a line break or another control character, which a form of submission cannot express
void requireNoControl(const std::string& word, const char* form);

}  // namespace betamesh
