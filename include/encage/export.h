// SPDX-License-Identifier: Apache-2.0
#pragma once

/// ENCAGE_EXPORT opens the namespace of a public header: what it declares is exported by the shared libraries, which
/// hide all else. ENCAGE_HIDDEN is for the definition, elsewhere, of a class of which a public header has only the
/// name.
#if defined(__GNUC__)
#define ENCAGE_EXPORT [[gnu::visibility("default")]]
#define ENCAGE_HIDDEN [[gnu::visibility("hidden")]]
#else
#define ENCAGE_EXPORT
#define ENCAGE_HIDDEN
#endif
