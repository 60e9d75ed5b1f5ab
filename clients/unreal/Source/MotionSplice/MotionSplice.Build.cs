using UnrealBuildTool;

public class MotionSplice : ModuleRules
{
	public MotionSplice(ReadOnlyTargetRules Target) : base(Target)
	{
		PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
		FPSemantics = FPSemanticsMode.Precise; // the evaluator checks for NaN, which fast mathematics assume away
		PublicDependencyModuleNames.AddRange(new[]
		{
			"Core", "CoreUObject", "Engine", "LiveLinkInterface", "LiveLinkAnimationCore"
		});
	}
}
