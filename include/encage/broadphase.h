// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kept for code that includes it: shapes and the test of pairs have headers of their own.

#include <encage/separated.h>
#include <encage/shape.h>
