// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Opens the namespace of a public header: what it declares is exported by the shared libraries, which hide all else.
#if defined(__GNUC__)
#define ENCAGE_EXPORT [[gnu::visibility("default")]]
#else
#define ENCAGE_EXPORT
#endif
