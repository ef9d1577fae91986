cmake_minimum_required(VERSION 3.22)
# Writes OUTPUT, a source with the version and the revision of SOURCE; leaves it alone when nothing has changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=10 --exclude=* OUTPUT_VARIABLE revision
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE unknown)
execute_process(COMMAND git -C ${SOURCE} status --porcelain --untracked-files=no OUTPUT_VARIABLE changes ERROR_QUIET)
if(unknown)
  set(revision "revision unknown")
elseif(changes)
  string(APPEND revision ", modified")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
  "#include \"version.hpp\"\n\nnamespace omniflight::cli {\nconst char* const kVersion = \"omniflight @VERSION@ (@revision@)\";\n}\n")
