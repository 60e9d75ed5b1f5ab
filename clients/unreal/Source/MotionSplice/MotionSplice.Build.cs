using UnrealBuildTool;

public class MotionSplice : ModuleRules
{
	public MotionSplice(ReadOnlyTargetRules Target) : base(Target)
	{
		PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
		PublicDependencyModuleNames.AddRange(new[]
		{
			"Core", "CoreUObject", "Engine", "LiveLinkInterface", "LiveLinkAnimationCore"
		});
	}
}
