"""`python -m isomend`: the command line."""

import sys

from isomend._command import main

sys.argv[0] = "isomend"
sys.exit(main())
