// Written by UnrealHeaderTool; empty here.
