# SPDX-License-Identifier: GPL-3.0-or-later
# Makes source files of the C++ blocks of documents, for a program that compiles and links them all.
#   awk -f extract.awk -v parts="runtime bullet" -v preludes=FOLDER -v out=FOLDER DOCUMENT.md…
# Writes out/snippets_PART.cpp for every part, and out/left_out.txt: "DOCUMENT:LINE: reason", one line for every block
# that is not compiled. What a block needs besides itself stands in a comment just before it:
#   <!-- snippet: prelude NAME -->        declarations in preludes/NAME.h, which says what it needs (read_prelude)
#   <!-- snippet: not compiled: REASON -->
# Fails where a block shows no header of ours, neither itself nor an earlier one of the same document and part.

function fail(message) {
  print "extract.awk: " FILENAME ":" FNR ": " message > "/dev/stderr"
  failed = 1
  exit 1
}

# A prelude is C++ for the namespace of the block; its #include lines go before that. Two comments have a meaning:
#   // needs: PART          the block is compiled where this part is built (default: runtime)
#   // scope: namespace     the block consists of declarations (default: of statements)
function read_prelude(name,    file, line, status) {
  prelude = ""
  prelude_includes = ""
  part = "runtime"
  statements = 1
  if (name == "") return
  file = preludes "/" name ".h"
  while ((status = (getline line < file)) > 0) {
    if (line ~ /^\/\/ needs: /) part = substr(line, 11)
    else if (line ~ /^\/\/ scope: namespace$/) statements = 0
    else if (line ~ /^#include /) prelude_includes = prelude_includes line "\n"
    else if (line !~ /^\/\/ SPDX/ && line !~ /^#pragma once/) prelude = prelude line "\n"
  }
  if (status < 0) fail("cannot read " file)
  close(file)
}

function start(line) {
  first_line = line
  includes = ""
  body = ""
  if (marker ~ /^not compiled: ./) {
    read_prelude("")
    reason = substr(marker, 15)
  } else if (marker == "" || marker ~ /^prelude [a-z_]+$/) {
    read_prelude(substr(marker, 9))
    reason = index(" " parts " ", " " part " ") ? "" : "needs " part ", which is not built"
  } else {
    fail("what does \"" marker "\" ask for?")
  }
}

function finish(    name) {
  if (reason != "") {
    print FILENAME ":" first_line ": " reason > left_out
    return
  }
  if (includes ~ /<encage\//) shown[FILENAME, part] = 1
  if (!((FILENAME, part) in shown)) fail("no block shows which header of ours the one of line " first_line " needs")
  name = "snippet_" ++count
  source = out "/snippets_" part ".cpp"
  print prelude_includes includes "namespace " name " {\n" prelude > source
  if (statements) print "void run() {" > source
  print "#line " first_line + 1 " \"" FILENAME "\"\n" body > source
  if (statements) print "}" > source
  print "const encage::docs::Snippet snippet(\"" FILENAME "\", " first_line ");\n}  // namespace " name "\n" > source
}

BEGIN {
  left_out = out "/left_out.txt"
  printf "" > left_out
  number = split(parts, names, " ")
  for (i = 1; i <= number; ++i) print "#include \"tests/docs/snippet.h\"\n" > (out "/snippets_" names[i] ".cpp")
}

/^<!-- snippet: .* -->$/ {
  marker = $0
  sub(/^<!-- snippet: /, "", marker)
  sub(/ -->$/, "", marker)
  next
}
inside && /^```$/ {
  finish()
  inside = 0
  marker = ""
  next
}
# Kept as an empty line, so that the compiler counts lines as the document does.
inside && /^#include / {
  includes = includes $0 "\n"
  body = body "\n"
  next
}
inside {
  body = body $0 "\n"
  next
}
/^```cpp$/ {
  start(FNR)
  inside = 1
  next
}
!/^$/ { marker = "" }

END {
  if (!failed && inside) fail("a block does not end")
}
